#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""manylight-chart as its users see it, its figures against manylight-compare's, and its tables by hand.

    chart_test.py RENDER COMPARE

Exit code 77, with the reason, where matplotlib is missing.
"""
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
CHART_FOLDER = ROOT / "programs" / "chart"
CHART = CHART_FOLDER / "manylight-chart"
CORNELL = ROOT / "examples" / "scenes" / "cornell.xml"
MOVING_LAMP = ROOT / "examples" / "scenes" / "moving_lamp.xml"
sys.dont_write_bytecode = True
sys.path.insert(0, str(CHART_FOLDER))

try:
    import matplotlib  # noqa: F401, pylint: disable=unused-import
    import numpy as np
except ImportError as missing:
    if os.access("/usr/bin/python3", os.X_OK) and not os.path.samefile(sys.executable, "/usr/bin/python3"):
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])
    print(f"skipped: {missing}; the package python3-matplotlib has it")
    sys.exit(77)

import errors  # noqa: E402
import images  # noqa: E402
import ladder  # noqa: E402
import runs  # noqa: E402
import tables  # noqa: E402

RENDER, COMPARE = "", ""  # set from the command line

# A renderer whose noise and bias are known: truth times (1 + bias + normal / sqrt(cost)), a thousandth of a second
# per cost. Method vpl is 1 % too bright. Without numpy, which takes longer to load than the rest.
STAND_IN = f"""#!{sys.executable} -IS
import array, json, random, sys, time
if "--version" in sys.argv:
    sys.exit(print("stand-in 1"))
words = sys.argv[2:]
given = {{word: words[i + 1] for i, word in enumerate(words[:-1]) if word.startswith("-")}}
method, seed = given["--method"], int(given["--seed"])
cost = int(given.get("--spp", 0)) or int(given["--eye-paths"]) ** 2
random.seed(f"{{method}} {{seed}} {{cost}}")
bias = 0.01 if method == "vpl" else 0
values = [(1 + i / 2000) * (1 + bias + 0.2 * random.gauss(0, 1) / cost ** 0.5) for i in range(24 * 32 * 3)]
with open(given["-o"], "wb") as file:
    data = b"PF\\n32 24\\n-1.0\\n" + array.array("f", values).tobytes()
    file.write(data[:5000])
    file.flush()
    time.sleep(float(words[words.index("--time-limit") + 1]) if "--time-limit" in words else 0)
    file.write(data[5000:])
seconds = {{"total": cost / 1000, "load": 0, "build": 0}}
with open(given["--stats"], "w") as file:
    json.dump({{"seconds": seconds, "rays": {{"closest": cost, "shadow": cost}}}}, file)
"""

FLOOR = """<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="2"/></integrator>
<sensor type="perspective"><float name="fov" value="40"/>
<transform name="to_world"><lookat origin="0,0,5" target="0,0,0" up="0,1,0"/></transform>
<film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film></sensor>
<shape type="rectangle"><transform name="to_world"><scale value="4"/></transform><bsdf type="diffuse"/></shape>
<emitter type="point"><point name="position" x="0" y="0" z="2"/></emitter></scene>
"""

# The real renderer, but that bdpt is path times 1.01.
BRIGHTER = f"""#!{sys.executable} -IS
import array, subprocess, sys
words = ["path" if word == "bdpt" else word for word in sys.argv[1:]]
code = subprocess.call([{sys.argv[1] if len(sys.argv) > 1 else ""!r}, *words])
if code == 0 and "bdpt" in sys.argv:
    name = words[words.index("-o") + 1]
    with open(name, "rb") as file:
        data = file.read()
    start = len(data) - 4 * 16 * 16 * 3
    values = array.array("f", [1.01 * value for value in array.array("f", data[start:])])
    with open(name, "wb") as file:
        file.write(data[:start] + values.tobytes())
sys.exit(code)
"""


def call(*words):
    """Exit code and error stream of manylight-chart."""
    run = subprocess.run([str(CHART), *map(str, words)], capture_output=True, text=True, check=False)
    return run.returncode, run.stderr


def compared(*words):
    """What manylight-compare says."""
    run = subprocess.run([COMPARE, *map(str, words), "--json"], capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


def without(value, names):
    """The same JSON without the keys `names`."""
    if isinstance(value, dict):
        return {key: without(entry, names) for key, entry in value.items() if key not in names}
    return [without(entry, names) for entry in value] if isinstance(value, list) else value


# What differs between two charts of the same images; commands by their folder.
TIMES = {"seconds", "setup_seconds", "cpu_seconds", "load", "date", "command"}


class Folder(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def small(self, output, *more):
        """Arguments of a chart that takes seconds."""
        return [CORNELL, "--render", RENDER, "--width", 16, "--height", 16, "--methods", "path,lightcuts", "--rungs", 2,
                "--seeds", 3, "--reference-spp", 16, "--reference-batches", 4, "--ledger-spp", 4, "-q", "-o",
                self.folder / output, *more]

    def stand_in(self):
        """Path of the renderer above."""
        path = self.folder / "stand-in"
        path.write_text(STAND_IN)
        path.chmod(0o755)
        return path

    def read_chart(self, output):
        """chart.json"""
        return json.loads((self.folder / output / "chart.json").read_text())


class Figures(Folder):
    """Oracle: manylight-compare, whose tests have closed forms; equal but for the order of sums."""

    def assert_close(self, own, other, path=""):
        """Every number of `other` is in `own`, to 1e-9 of it: rounding of sums, and of differences of them."""
        for name, value in other.items():
            if isinstance(value, dict):
                self.assert_close(own[name], value, path + name + ".")
            elif value is None:
                self.assertFalse(np.isfinite(own[name]), path + name)
            else:
                self.assertAlmostEqual(own[name], value, delta=1e-9 * max(abs(value), 1e-3), msg=path + name)

    def setUp(self):
        super().setUp()
        random = np.random.default_rng(5)
        truth = 0.01 + random.random((40, 50, 3)) ** 3
        self.files = []
        for i in range(8):
            path = self.folder / f"{i}.pfm"
            images.write_pfm(path, truth * (1.02 + 0.4 * random.standard_normal(truth.shape)))
            self.files.append(path)

    # Planted bugs seen to fail here: one pixel more trimmed, MAPE over r alone, SSIM without its tone curve.
    def test_pair(self):
        pictures = [images.read(path) for path in self.files[:2]]
        self.assert_close(errors.measure(*pictures), compared(*self.files[:2]))

    # Planted bugs seen to fail here: jackknife of the runs alone, sample variance with ddof 0.
    def test_split(self):
        pictures = [images.read(path) for path in self.files]
        for count in (2, 3, 5):
            for references in (pictures[count:], pictures[count:count + 1]):
                files = self.files[count:count + len(references)]
                other = compared("--runs", *self.files[:count], "--reference", *files)
                self.assert_close(errors.split(pictures[:count], references), other)

    # Oracle: planted. Unbiased runs, a reference of relative variance 0.0025, more than ten standard errors of bias^2.
    # Planted bugs seen to fail here: noise added, taken off twice, off MSE not at all, off the variance or the absolute
    # figures as well.
    def test_split_takes_off_given_noise(self):
        random = np.random.default_rng(6)
        truth = 1 + random.random((100, 100, 3))
        pictures = [truth * (1 + 0.3 * random.standard_normal(truth.shape)) for _ in range(8)]
        file = truth * (1 + 0.05 * random.standard_normal(truth.shape))
        noise = ((0.05 * truth) ** 2 / (truth ** 2 + errors.dark_term(truth))).mean()
        raw, corrected = errors.split(pictures, [file]), errors.split(pictures, [file], noise)
        error = corrected["rel_bias_squared"]["standard_error"]
        self.assertLess(abs(corrected["rel_bias_squared"]["value"]), 3 * error)
        self.assertGreater(raw["rel_bias_squared"]["value"], 10 * error)
        # MSE is variance and bias^2 still, and only the relative figures can be corrected.
        parts = [corrected[f"rel_{name}"]["value"] for name in ("mse", "variance", "bias_squared")]
        self.assertAlmostEqual(parts[0], parts[1] + parts[2], delta=1e-12)
        changed = {name for name in raw if raw[name] != corrected[name]}
        self.assertEqual(changed, {"rel_mse", "rel_bias_squared", "rel_reference_variance"})
        self.assertEqual(corrected["rel_reference_variance"], noise)

    # Oracle: the PFM of the same run.
    def test_exr_is_read(self):
        exr, pfm = self.folder / "a.exr", self.folder / "a.pfm"
        subprocess.run([RENDER, str(CORNELL), "--method", "path", "--size", "37x21", "--spp", "1", "-q", "-o", str(exr),
                        "-o", str(pfm)], check=True)
        self.assertTrue(np.array_equal(images.read(exr), images.read(pfm)))
        self.assertEqual(images.read(exr).shape, (21, 37, 3))


class Tables(unittest.TestCase):
    """Oracle: by hand."""

    def test_reasons_of_refusals(self):
        words = "manylight-render: --method pppm is for a scene {}, allowed: path, bdpt or bdlc"
        for given, reason in (("in motion", "in motion"), ("with glue ('<glue type=\"hot\">')", "with glue")):
            self.assertEqual(runs.refusal_reason(words.format(given)), "a scene " + reason)
        self.assertIsNone(runs.refusal_reason("manylight-render: --method: photons not in {path}"))

    # Planted bugs seen to fail here: interpolation of the plain error, extrapolation beyond the last point.
    def test_time_to(self):
        times, found = [1.0, 4.0, 16.0], [0.4, 0.2, 0.1]  # slope -1/2
        self.assertAlmostEqual(tables.time_to(0.2, times, found), 4.0)
        self.assertAlmostEqual(tables.time_to(0.4 / 2 ** 0.5, times, found), 2.0)
        self.assertAlmostEqual(tables.time_to(0.1, times, found), 16.0)
        self.assertEqual(tables.time_to(0.4, times, found), tables.FROM_THE_START)
        self.assertEqual(tables.time_to(0.099, times, found), tables.NOT_REACHED)

    def test_speed_ups(self):
        rows = tables.time_table({"path": ([1.0, 16.0], [0.4, 0.1]), "fast": ([1.0, 4.0], [0.4, 0.1]),
                                  "stuck": ([1.0, 4.0], [0.4, 0.3])}, "path")
        self.assertEqual([row["level"] for row in rows], [0.2, 0.1])
        self.assertAlmostEqual(rows[0]["times"]["path"], 4.0)
        self.assertAlmostEqual(rows[0]["speed_ups"]["fast"], 2.0)
        self.assertAlmostEqual(rows[1]["speed_ups"]["fast"], 4.0)
        self.assertNotIn("stuck", rows[1]["speed_ups"])

    def test_ladder_ends_at_the_budget(self):
        self.assertTrue(ladder.is_affordable([], 1))
        self.assertTrue(ladder.is_affordable([5], 1))  # two rungs at least
        self.assertTrue(ladder.is_affordable([0.1, 0.3], 1))
        self.assertFalse(ladder.is_affordable([0.1, 0.4], 1))
        self.assertFalse(ladder.is_affordable([1e-6] * 12, 1))

    # Oracle: the defaults of manylight-render, 64 eye paths and 1,000,000 lights, are near the third step.
    # Planted bugs seen to fail here: 2 eye paths at first, lights doubled.
    def test_ladder_of_cuts(self):
        for method in ("lightcuts", "bdlc"):
            self.assertEqual(ladder.settings(method, 0), {"eye-paths": 64, "vpls": 64_000})
            self.assertEqual(ladder.settings(method, 2), {"eye-paths": 256, "vpls": 1_024_000})

    def test_levels(self):
        self.assertEqual(tables.levels_between(0.04, 1.0), [1.0, 0.5, 0.2, 0.1, 0.05])
        self.assertEqual(tables.median([3, 1, 2]), 2)
        self.assertEqual(tables.median([4, 1, 2, 3]), 2.5)


def rung(seconds, rel_mse):
    """A rung of a chart as its summary reads it; three seeds, medians as given."""
    return {"runs": [{"seconds": factor * seconds, "rel_mse": factor * rel_mse} for factor in (1, 0.5, 7)]}


class Summaries(Folder):
    """Oracle: by hand."""

    def written(self, name, noise, methods, **more):
        """A chart.json with what a summary needs; `noise` is the reference's relative variance."""
        (self.folder / name).mkdir(parents=True)
        chart = {"version": "manylight-render 1", "date": "2026-01-02T03:04:05Z", "scene": "s.xml", "scene_name": "s",
                 "machine": {"processor": "P", "cores": 2, "system": "S"}, "load": {"least": 0, "most": 1},
                 "parameters": {"seeds": 3, "clock": "wall"}, "width": 4, "height": 3, "methods": methods,
                 "reference": {"rel_variance": noise}, "not_applicable": [], **more}
        (self.folder / name / "chart.json").write_text(json.dumps(chart))

    def rows(self):
        """Cells of the printed table, and all else that is printed."""
        run = subprocess.run([str(CHART), "--summary", str(self.folder)], capture_output=True, text=True, check=True)
        lines = run.stdout.splitlines()
        table = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith("| ")]
        return table[2:], "\n".join(line for line in lines if not line.startswith("| "))

    # relMSE is that of the rungs less the reference's noise. Planted bugs seen to fail here: relMSE as it
    # is, without a least, a file's noise left in, means over seeds, levels within the reference's noise, bias^2 without
    # its error, the path of the program in a command.
    def test_one_row_per_scene_and_method(self):
        falling = [rung(1, 0.04), rung(4, 0.01), rung(16, 0.0025)]  # relMSE 0.04 / seconds
        biased = [rung(1, 0.02), rung(4, 0.009)]
        biased[-1]["split"] = {"rel_bias_squared": {"value": 0.008, "standard_error": 0.001}}
        unsure = [rung(2, 0.009), rung(5, 0.004)]
        unsure[-1]["split"] = {"rel_bias_squared": {"value": 0.004, "standard_error": 0.001}}
        share = {"against_reference": {"value": 0.021, "standard_error": 0.001}}
        self.written("b/one", 0.0001, [{"label": "path", "rungs": falling, "missing": None},
                                       {"label": "vpl", "rungs": biased, "missing": share},
                                       {"label": "ir", "rungs": unsure, "missing": None}],
                     command="manylight-chart 'a b.xml' --render /r/m --seeds 3 -q -o /out",
                     not_applicable=[{"label": "pppm", "reason": "a scene in motion"}])
        self.written("a", 0.002, [{"label": "path", "rungs": falling, "missing": None}])
        for name, noise in (("c", 0.0024), ("d", None)):
            self.written(name, noise, [{"label": "path", "rungs": falling, "missing": None}],
                         reference={"file": "r.exr", "rel_variance": noise})
        rows, text = self.rows()
        # Between (1, 0.038) and (4, 0.008): 4^(log 3.8 / log 4.75) = 3.28.
        self.assertEqual(rows[0], ["a 4x3", "path", "3.28", "4.62 (to 0.006)", "16", "0.0005", "-", "-"])
        self.assertEqual(rows[1], ["b/one 4x3", "path", "3.96", "12.9", "16", "0.0024", "-", "-"])
        # Between (1, 0.0199) and (4, 0.0089): 4^(log 1.99 / log (199 / 89)) = 3.27.
        self.assertEqual(rows[2], ["b/one 4x3", "vpl", "3.27", "never, bias² 0.008", "4", "0.0089",
                                   "0.008 ± 0.001", "2.10 ± 0.10 %"])
        self.assertEqual(rows[3], ["b/one 4x3", "ir", "< 2", "> 5", "5", "0.0039", "0.004 ± 0.001", "-"])
        self.assertEqual(rows[4][:3], ["b/one 4x3", "pppm", "not applicable: a scene in motion"])
        # Of 0.0025 a tenth of the noise stays: between (4, 0.0076) and (16, 0.00024).
        self.assertEqual(rows[5], ["c 4x3", "path", "3.15", "4.09 (to 0.0072)", "16", "0.00024", "-", "-"])
        self.assertEqual(rows[6], ["d 4x3", "path", "4", "13.3", "16", "0.0025", "-", "-"])
        self.assertEqual(len(rows), 7)
        self.assertIn("; relative variance of the reference file, as given: 0.0024; ", text)
        self.assertIn("; reference from a file, whose noise counts as error and bias; ", text)
        self.assertIn("Measured with manylight-render 1, P, 2 cores, S.", text)
        self.assertIn("- b/one, 2026-01-02: 3 seeds, wall seconds, load 0.0 to 1.0; relative variance of the reference "
                      "0.0001; `manylight-chart 'a b.xml' --seeds 3`", text)

    # Oracle: the chart's own JSON, of the real program.
    def test_of_a_real_chart(self):
        self.assertEqual(call(*self.small("c")), (0, ""))
        chart, (rows, text) = self.read_chart("c"), self.rows()
        self.assertEqual([row[:2] for row in rows], [["c 16x16", "path"], ["c 16x16", "lightcuts"]])
        for row, method in zip(rows, chart["methods"]):
            noise = chart["reference"]["rel_variance"]
            there = max(sorted(run["rel_mse"] for run in method["rungs"][-1]["runs"])[1] - noise, 0.1 * noise)
            self.assertAlmostEqual(float(row[5]), there, delta=0.06 * there)
        self.assertIn(f"`manylight-chart {CORNELL} --width 16", text)
        self.assertNotIn("--render", text)


class Charts(Folder):
    """A tiny scene from end to end."""

    def test_end_to_end(self):
        self.assertEqual(call(*self.small("a")), (0, ""))
        chart = self.read_chart("a")
        output = self.folder / "a"
        for name in ("error_over_time", "error_over_rays"):
            self.assertEqual((output / f"{name}.png").read_bytes()[:4], b"\x89PNG")
            self.assertIn("<svg", (output / f"{name}.svg").read_text())
        page = (output / "chart.html").read_text()
        self.assertEqual(len(re.findall(r'<img [^>]*src="data:image/', page)), 3)
        self.assertNotIn("<script", page)
        self.assertEqual(re.findall(r'(?:src|href)="(?!data:)', page), [])
        self.assertFalse((output / "unfinished").exists())
        self.assertEqual([m["label"] for m in chart["methods"]], ["path", "lightcuts"])
        self.assertIsNone(chart["methods"][0]["missing"])
        missing = chart["methods"][1]["missing"]
        self.assertGreater(missing["against_reference"]["value"], 0)
        self.assertAlmostEqual(missing["against_reference"]["value"] + missing["entries"]["depth"],
                               missing["total"]["value"])
        for method in chart["methods"]:
            self.assertEqual([len(rung["runs"]) for rung in method["rungs"]], [3, 3])
        # A point by hand: the same bits from its command, the same figures from manylight-compare.
        batches = [images.read(output / run["image"]) for run in chart["reference"]["runs"]]
        images.write_pfm(self.folder / "truth.pfm", np.mean(batches, axis=0))
        for method in chart["methods"]:
            run = method["rungs"][1]["runs"][2]
            kept = (output / run["image"]).read_bytes()
            (output / run["image"]).unlink()
            subprocess.run(shlex.split(run["command"]), check=True)
            self.assertEqual((output / run["image"]).read_bytes(), kept)
            figures = compared(output / run["image"], self.folder / "truth.pfm")
            for key in ("rmse", "rel_mse", "mape", "ssim"):
                self.assertAlmostEqual(run[key], figures[key], delta=1e-5 * abs(figures[key]))  # the truth as float
        self.second_call()

    def second_call(self):
        """Does no run again, and finds the same figures."""
        records = sorted((self.folder / "a" / "runs").glob("*.json"))
        before, chart = [path.stat().st_mtime_ns for path in records], self.read_chart("a")
        self.assertEqual(call(*self.small("a")), (0, ""))
        self.assertEqual([path.stat().st_mtime_ns for path in records], before)
        again = self.read_chart("a")
        chart.pop("date"), again.pop("date")  # the runs' own dates stay
        self.assertEqual(again, chart)
        # More seeds: the old runs stay.
        self.assertEqual(call(*self.small("a", "--seeds", 4)), (0, ""))
        self.assertEqual([path.stat().st_mtime_ns for path in records], before)
        first = without(self.read_chart("a")["methods"][0]["rungs"][0]["runs"][0], {})
        self.assertEqual(first, chart["methods"][0]["rungs"][0]["runs"][0])

    # Oracle: the chart that nobody interrupted. The renderer takes a rest in the middle of its image, so that the calls
    # are ended there. Planted bugs seen to fail here: an image that is there counts as finished; names of runs hold the
    # settings in the order of the ladder (photonmap's are not in that of the alphabet).
    def test_resumes_after_kill(self):
        words = [CORNELL, "--render", self.stand_in(), "--methods", "path,vpl,photonmap", "--rungs", 2, "--seeds", 3,
                 "--reference-spp", 16, "--reference-batches", 4, "--ledger-spp", 0, "-q", "--with", "time-limit=0.1"]
        self.assertEqual(call(*words, "-o", self.folder / "whole"), (0, ""))
        halves = self.folder / "halves"
        for number, count in ((signal.SIGTERM, 2), (signal.SIGKILL, 5), (signal.SIGINT, 9)):
            command = [str(CHART), *map(str, words), "-o", str(halves)]
            with subprocess.Popen(command, stderr=subprocess.DEVNULL) as child:
                until = time.monotonic() + 60
                while len(list(halves.glob("runs/*.json"))) < count and time.monotonic() < until:
                    time.sleep(0.002)
                time.sleep(0.05)
                child.send_signal(number)
                self.assertIn(child.wait(60), (130, -number))
        self.assertFalse((halves / "chart.json").exists())
        self.assertEqual(call(*words, "-o", halves), (0, ""))
        self.assertEqual(without(self.read_chart("halves"), TIMES), without(self.read_chart("whole"), TIMES))
        self.assertFalse((halves / "unfinished").exists())

    # Oracle: planted. Noise of 0.2 / sqrt(64) per pixel, so that 1 % is hidden in each image and shows over 8 seeds:
    # the standard error of bias^2 is near 6e-6 of 1e-4. Beyond 5 of them lies 0.2 % of Student's t of 7 degrees; seeds
    # are fixed. Planted bugs seen to fail here: noise of the runs or of the reference not taken off, a
    # floor of the variance alone.
    def test_one_percent_of_bias_shows(self):
        code = call(CORNELL, "--render", self.stand_in(), "--methods", "path,vpl,lightcuts", "--rungs", 3, "--seeds", 8,
                    "--reference-spp", 1000, "--reference-batches", 8, "--ledger-spp", 0, "-q", "-o", self.folder / "b")
        self.assertEqual(code, (0, ""))
        chart = self.read_chart("b")
        floors = {method["label"]: method["bias_floor"] for method in chart["methods"]}
        self.assertAlmostEqual(floors["vpl"]["value"], 0.01, delta=0.0015)
        for label in ("path", "lightcuts"):
            self.assertIsNone(floors[label]["value"])
            self.assertLess(floors[label]["below"], 0.006)
        truth = 1 + np.arange(24 * 32 * 3) / 2000
        planted = 1e-4 * (truth ** 2 / (truth ** 2 + (0.05 * truth.mean()) ** 2)).mean()
        self.assert_bias(chart, {"path": 0.0, "vpl": planted, "lightcuts": 0.0}, 1e-5)
        self.by_hand(chart, self.folder / "b")
        # relMSE 0.04 / cost and a thousandth of a second per cost: 0.05 takes 0.016 s, within the noise of medians.
        row = next(row for row in chart["time_to_error"]["rows"] if row["level"] == 0.05)
        self.assertAlmostEqual(row["times"]["path"], 0.016, delta=0.001)
        self.assertEqual(row["times"]["path"], row["speed_ups"]["path"] * row["times"]["path"])
        drawn = (self.folder / "b" / "error_over_time.svg").read_text()
        table = (self.folder / "b" / "table.md").read_text().splitlines()
        self.assertEqual(len(table), 2 + 9)
        self.assertRegex(table[4], r"^\| cornell 32x24 \| path, 64 spp \| ")
        self.assertIn("bias of vpl", drawn)
        self.assertNotIn("bias of path", drawn)

    def assert_bias(self, chart, planted, largest_error):
        """bias^2 and floor of the dearest rung are what was planted, within 5 standard errors, which are small."""
        for method in chart["methods"]:
            found = method["rungs"][-1]["split"]["rel_bias_squared"]
            self.assertLess(found["standard_error"], largest_error, method["label"])
            for value in (found["value"], (method["bias_floor"]["value"] or 0) ** 2):
                error = abs(value - planted[method["label"]])
                self.assertLess(error, 5 * found["standard_error"], method["label"])

    # Planted bugs seen to fail here: the mean of seeds instead of the median, straight lines of the plain time.
    def by_hand(self, chart, folder):
        """The dearest point of vpl, its floor and a time of path again, from chart.json and the images it names.

        Oracle: definitions. bias^2 by products of errors that share neither run nor batch; no inner products, no sums
        of them.
        """
        def pixels(run):
            data = (folder / run["image"]).read_bytes()
            return np.frombuffer(data, "<f4", offset=len(data) - 4 * 24 * 32 * 3).astype(float)
        method = chart["methods"][1]
        point = method["rungs"][-1]
        batches = [pixels(run) for run in chart["reference"]["runs"]]
        truth = sum(batches) / len(batches)
        weights = 1 / (truth ** 2 + (0.05 * truth.mean()) ** 2)
        found = [pixels(run) for run in point["runs"]]
        for run, image in zip(point["runs"], found):
            self.assertAlmostEqual(run["rel_mse"], (weights * (image - truth) ** 2).mean(), delta=1e-9)
        products = [(weights * (x - r) * (y - s)).mean() for i, x in enumerate(found) for y in found[:i]
                    for j, r in enumerate(batches) for k, s in enumerate(batches) if j != k]
        bias_squared, split = sum(products) / len(products), point["split"]
        self.assertAlmostEqual(split["rel_bias_squared"]["value"], bias_squared, delta=1e-9)
        variance = (weights * np.var(found, axis=0, ddof=1)).mean()
        self.assertAlmostEqual(split["rel_variance"]["value"], variance, delta=1e-9)
        self.assertAlmostEqual(method["bias_floor"]["value"], bias_squared ** 0.5, delta=1e-7)
        # The first level that path reaches after its first point, along the line in log-log to the point below it.
        def middle(rung, key):
            return sum(sorted(run[key] for run in rung["runs"])[3:5]) / 2  # of 8 seeds
        curve = [(middle(rung, "seconds"), middle(rung, "rel_mse") ** 0.5) for rung in chart["methods"][0]["rungs"]]
        row = next(row for row in chart["time_to_error"]["rows"] if isinstance(row["times"]["path"], float))
        after = next(i for i, (_, error) in enumerate(curve) if error <= row["level"])
        (t0, e0), (t1, e1) = curve[after - 1], curve[after]
        slope = np.log(e1 / e0) / np.log(t1 / t0)
        self.assertAlmostEqual(row["times"]["path"], t0 * (row["level"] / e0) ** (1 / slope), delta=1e-9)

    # Oracle: planted. The real program, whose path stands in for bdpt and is made 1 % brighter there; a floor under a
    # point light has little noise. Planted bug seen to fail here: a floor of the variance alone.
    def test_one_percent_of_bias_shows_in_real_images(self):
        (self.folder / "brighter").write_text(BRIGHTER)
        (self.folder / "brighter").chmod(0o755)
        (self.folder / "floor.xml").write_text(FLOOR)
        code = call(self.folder / "floor.xml", "--render", self.folder / "brighter", "--methods", "path,bdpt",
                    "--rungs", 3, "--seeds", 6, "--reference-spp", 128, "--reference-batches", 6, "-q",
                    "-o", self.folder / "r")
        self.assertEqual(code, (0, ""))
        chart = self.read_chart("r")
        batches = [images.read(self.folder / "r" / run["image"]) for run in chart["reference"]["runs"]]
        truth = np.mean(batches, axis=0)
        planted = 1e-4 * (truth ** 2 / (truth ** 2 + errors.dark_term(truth))).mean()
        self.assert_bias(chart, {"path": 0.0, "bdpt": planted}, 2e-5)

    # The real program's words for it. Planted bug seen to fail here: the first method is rendered to try the reference.
    def test_methods_that_refuse_the_scene_are_listed(self):
        words = [MOVING_LAMP, "--render", RENDER, "--methods", "pppm,path,photonmap", "--rungs", 1, "--seeds", 2,
                 "--width", 8, "--height", 6, "--with", "instants=2"]
        code, message = call(*words, "--reference-spp", 4, "--reference-batches", 3, "-o", self.folder / "m")
        self.assertEqual(code, 0)
        self.assertIn("pppm: not applicable: a scene in motion\n", message)
        chart = self.read_chart("m")
        self.assertEqual([method["label"] for method in chart["methods"]], ["path"])
        self.assertEqual([entry["label"] for entry in chart["not_applicable"]], ["pppm", "photonmap"])
        self.assertEqual(chart["not_applicable"][0]["reason"], "a scene in motion")
        self.assertIn("motion", chart["not_applicable"][1]["reason"])
        page = (self.folder / "m" / "chart.html").read_text()
        self.assertIn("<p>Not applicable: pppm, a scene in motion.</p>", page)
        self.assertIn("| pppm | not applicable: a scene in motion |", (self.folder / "m" / "table.md").read_text())
        reference = self.folder / "m" / chart["reference"]["runs"][0]["image"]
        self.assertEqual(call(*words, "-q", "--reference", reference, "-o", self.folder / "f"), (0, ""))

    # Oracle: planted noise of 0.02 in the file, a tenth of that of a sample; rows lie upside down in a PFM.
    # Planted bugs seen to fail here: noise added, taken off twice or not, a variance of null or of 0 in place of null,
    # its share of the largest error.
    def test_reference_from_a_file(self):
        truth = self.folder / "truth.pfm"
        exact = (1 + np.arange(24 * 32 * 3) / 2000).reshape(24, 32, 3)[::-1]
        images.write_pfm(truth, exact * (1 + 0.02 * np.random.default_rng(7).standard_normal(exact.shape)))
        words = [CORNELL, "--render", self.stand_in(), "--methods", "path", "--rungs", 2, "--seeds", 6, "-q", "-o",
                 self.folder / "c", "--reference", truth]
        self.assertEqual(call(*words), (0, ""))
        raw = self.read_chart("c")
        self.assertEqual(raw["reference"], {"file": str(truth), "rel_variance": None, "share_of_least_error": None})
        self.assertIn("taken as exact", (self.folder / "c" / "chart.html").read_text())
        noise = 0.02 ** 2 * (exact ** 2 / (exact ** 2 + errors.dark_term(exact))).mean()
        self.assertEqual(call(*words, "--metric", "trimmed", "--reference-noise", noise), (0, ""))
        chart = self.read_chart("c")
        least = np.median([run["rel_mse"] for run in chart["methods"][0]["rungs"][-1]["runs"]])
        self.assertEqual(chart["reference"]["rel_variance"], noise)
        self.assertAlmostEqual(chart["reference"]["share_of_least_error"], noise / least)
        self.assertIn(f"as given with --reference-noise, {noise:.2g}, {100 * noise / least:.2g} % of the least error",
                      (self.folder / "c" / "chart.html").read_text())
        floors = [of["methods"][0]["bias_floor"]["below"] ** 2 for of in (raw, chart)]
        self.assertAlmostEqual(floors[0] - floors[1], noise, delta=1e-9)
        code, message = call(*words, "--reference-noise", 0.5)
        self.assertEqual(code, 2)
        self.assertRegex(message, r"^manylight-chart: --reference-noise: 0.5, allowed: at most the least relMSE of all "
                                  r"methods, 0\.0\d+\n$")
        images.write_pfm(truth, np.ones((24, 16, 3)))
        code, message = call(*words)
        self.assertEqual((code, message), (2, "manylight-chart: the reference has 16 x 24 pixels, the runs 32 x 24\n"))


class Program(Folder):
    """What surrounds the charts."""

    # Oracle: the other of the two.
    def test_options_are_documented(self):
        run = subprocess.run([str(CHART), "--help"], capture_output=True, text=True, check=True)
        known = set(re.findall(r"--[a-z][a-z-]+", run.stdout)) - {"--help"}
        rows = re.findall(r"^\| (`-[^|]*) \|", (ROOT / "docs" / "charts.md").read_text(), re.MULTILINE)
        self.assertEqual(set(re.findall(r"--[a-z][a-z-]+", " ".join(rows))), known)

    def test_installed_layout(self):
        (self.folder / "bin").mkdir()
        shutil.copy(CHART, self.folder / "bin")
        (self.folder / "share" / "manylight" / "chart").mkdir(parents=True)
        for module in CHART_FOLDER.glob("*.py"):
            shutil.copy(module, self.folder / "share" / "manylight" / "chart")
        run = subprocess.run([str(self.folder / "bin" / "manylight-chart"), "--help"], capture_output=True, text=True,
                             check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("--budget", run.stdout)


class BadInput(Folder):
    """One line, exit code 2."""

    def rejected(self, mentions, *words):
        """Oracle: the contract."""
        code, message = call(*words, "-q", "-o", self.folder / "bad")
        self.assertEqual(code, 2, message)
        self.assertEqual(message.count("\n"), 1, message)
        self.assertTrue(message.startswith("manylight-chart: "), message)
        self.assertIn(mentions, message)

    def test_command_lines(self):
        damaged = self.folder / "damaged.pfm"
        damaged.write_bytes(b"PF\n16 16\n-1.0\n12")
        text = self.folder / "text.exr"
        text.write_text("text")
        fast = [CORNELL, "--render", self.stand_in(), "--rungs", 1, "--seeds", 1, "--methods", "path"]
        self.rejected("scene")
        self.rejected("nowhere.xml: No such file", "nowhere.xml", "--render", RENDER)
        self.rejected("no such program", CORNELL, "--render", self.folder / "none")
        self.rejected("--budget", CORNELL, "--budget", "-1")
        self.rejected("--seeds", CORNELL, "--seeds", "many")
        self.rejected("--clock", CORNELL, "--clock", "sun")
        self.rejected("go together", CORNELL, "--width", "4")
        self.rejected("--reference-batches", CORNELL, "--reference-batches", "2")
        for value in ("1", "-0.1", "nan", "inf", "much"):
            for part in ("--reference-noise", f"'{value}'", "0 <= V < 1"):
                self.rejected(part, CORNELL, "--reference", damaged, f"--reference-noise={value}")
        self.rejected("--reference-noise 0.002 is that of a file: only with --reference", CORNELL, "--reference-noise",
                      "0.002")
        self.rejected("'=4'", *fast, "--methods", "path+=4")
        self.rejected("twice", *fast, "--methods", "path,path")
        self.rejected("scene in motion", MOVING_LAMP, "--render", RENDER, "--methods", "pppm")
        self.rejected("--summary", CORNELL, "--summary", self.folder)
        self.rejected("no chart.json", "--summary", self.folder)
        (self.folder / "chart.json").write_text("{}")
        self.rejected("not a chart", "--summary", self.folder)
        self.rejected("photons", CORNELL, "--render", RENDER, "--methods", "photons")
        self.rejected("window", CORNELL, "--render", RENDER, "--methods", "path", "--window", "0,0,9000,2")
        self.rejected("none.pfm: No such file", *fast, "--reference", "none.pfm")
        self.rejected("damaged", *fast, "--reference", damaged)
        images.write_pfm(self.folder / "black.pfm", np.zeros((24, 32, 3)))
        self.rejected("black", *fast, "--reference", self.folder / "black.pfm")
        self.rejected("neither PFM nor EXR", *fast, "--reference", text)

    def test_folder_in_use_or_impossible(self):
        import fcntl  # pylint: disable=import-outside-toplevel
        (self.folder / "bad").mkdir()
        with open(self.folder / "bad" / ".lock", "w", encoding="ascii") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.rejected("at work", CORNELL, "--render", RENDER)
        shutil.rmtree(self.folder / "bad")
        (self.folder / "bad").write_text("a file")
        self.rejected("bad", CORNELL, "--render", RENDER)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("usage: chart_test.py RENDER COMPARE [TEST...]")
    RENDER, COMPARE = sys.argv[1:3]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)
