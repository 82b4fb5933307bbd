# SPDX-License-Identifier: Apache-2.0
"""Which runs a chart needs, and doing them. Seed 1 climbs the ladder first: its times decide how far it reaches."""
import evaluate
import ladder
import progress
import runs
from failure import NotApplicable

REFERENCE_SEED = 1_000_000  # the first; runs count from 1
LEDGER_SEED = 2_000_000


def _show(job, left, quiet):
    """`left`: seconds of this job and those after it, or None while nobody knows."""
    tail = f"about {progress.duration(left)} left" if left is not None else "finding how far the ladder goes"
    progress.show(f"{runs.job_name(job)}; {tail}", quiet)


def applicable(context, methods, quiet):
    """The methods that are for the scene, by their first runs, and {label, reason} of the others.

    Raises NotApplicable if none is left.
    """
    kept, refused = [], []
    for method in methods:
        job = runs.make_job(method, ladder.settings(method["method"], 0), 1)
        if runs.find(context, job) is None:
            _show(job, None, quiet)
        try:
            runs.do(context, job)
            kept.append(method)
        except NotApplicable as refusal:
            progress.show(f"{method['label']}: not applicable: {refusal.reason}", quiet)
            refused.append({"label": method["label"], "reason": refusal.reason})
            last = refusal
    if not kept:
        raise last
    return kept, refused


def climb(context, method, budget, options):
    """Records of seed 1 at each rung: as many as the options ask for, or as the budget allows on their clock."""
    clock = evaluate.CLOCKS[options.clock]
    records = []
    while (len(records) < options.rungs if options.rungs else
           ladder.is_affordable([record[clock] for record in records], budget)):
        job = runs.make_job(method, ladder.settings(method["method"], len(records)), 1)
        if runs.find(context, job) is None:
            _show(job, None, options.quiet)
        records.append(runs.do(context, job))
    return records


def reference_spp(per_sample, batches, budget):
    """Samples per pixel of a batch so that all take about `budget` seconds: a power of 2."""
    spp = 1
    while 2 * spp * batches * per_sample <= budget:
        spp *= 2
    return spp


def reference_jobs(context, records, options):
    """Batches of path tracing with seeds of their own, and the wall seconds of one; none if a file is the reference."""
    if options.reference:
        return [], 0.0
    path = {"label": "path", "method": "path", "arguments": []}
    probes = records.get("path") or climb(context, path, options.budget / 4, options)
    per_sample = probes[-1][evaluate.CLOCKS[options.clock]] / probes[-1]["settings"]["spp"]
    spp = options.reference_spp or reference_spp(per_sample, options.reference_batches, options.reference_budget)
    seeds = range(REFERENCE_SEED, REFERENCE_SEED + options.reference_batches)
    wall_per_sample = probes[-1]["seconds"] / probes[-1]["settings"]["spp"]
    return [runs.make_job(path, {"spp": spp}, seed) for seed in seeds], spp * wall_per_sample


def ledger_jobs(methods, records, options):
    """One run per many-light method that books what its dearest rung leaves out."""
    jobs = {}
    for method in methods:
        settings = records[method["label"]][-1]["settings"]
        if "vpls" in settings and options.ledger_spp > 0:
            few = {"eye-paths": 1, "vpls": settings["vpls"], "ledger-spp": options.ledger_spp}
            jobs[method["label"]] = runs.make_job(method, few, LEDGER_SEED)
    return jobs


def do_all(context, jobs, expected, quiet):
    """Does the jobs that are missing, in order; `expected` are their seconds."""
    missing = [(job, seconds) for job, seconds in zip(jobs, expected) if runs.find(context, job) is None]
    left = sum(seconds for _, seconds in missing)
    for job, seconds in missing:
        _show(job, left, quiet)
        runs.do(context, job)
        left -= seconds


def carry_out(context, methods, options):
    """Records: per method and rung those of all seeds, of the reference, of the ledger."""
    climbed = {m["label"]: climb(context, m, options.budget, options) for m in methods}
    batches, batch_seconds = reference_jobs(context, climbed, options)
    ledger = ledger_jobs(methods, climbed, options)
    # Seeds outside, methods inside: a machine that slows down for a while does so for all of them.
    jobs, expected = [], []
    for seed in range(2, options.seeds + 1):
        for method in methods:
            for record in climbed[method["label"]]:
                jobs.append(runs.make_job(method, record["settings"], seed))
                expected.append(record["seconds"])
    for job in batches:
        jobs.append(job)
        expected.append(batch_seconds)
    for label, job in ledger.items():
        jobs.append(job)
        expected.append(climbed[label][-1]["seconds"])
    do_all(context, jobs, expected, options.quiet)
    progress.close(options.quiet)

    def all_seeds(method, record):
        seeds = range(1, options.seeds + 1)
        return [runs.find(context, runs.make_job(method, record["settings"], seed)) for seed in seeds]

    return {
        "methods": {m["label"]: [all_seeds(m, record) for record in climbed[m["label"]]] for m in methods},
        "reference": [runs.find(context, job) for job in batches],
        "ledger": {label: runs.find(context, job) for label, job in ledger.items()},
    }
