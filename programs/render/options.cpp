// SPDX-License-Identifier: Apache-2.0
#include "render/options.hpp"

#include <algorithm>
#include <cmath>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>

#include "manylight/core/config.hpp"
#include "manylight/core/error.hpp"

namespace manylight::render {

namespace {

/// "name=value" split at the first "="; throws ParameterError.
std::pair<std::string, std::string> split_assignment(const std::string& option, const std::string& text) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size()) {
    throw ParameterError(option, "'" + text + "'", "name=value");
  }
  return {text.substr(0, at), text.substr(at + 1)};
}

void set_size(Options& options, const std::string& text) {
  unsigned width = 0;
  unsigned height = 0;
  char rest = 0;
  // NOLINTNEXTLINE(cert-err34-c): three conversions or the text is rejected
  if (std::sscanf(text.c_str(), "%5ux%5u%c", &width, &height, &rest) != 2 || width < 1 || height < 1 || width > 32768 ||
      height > 32768) {
    throw ParameterError("--size", "'" + text + "'", "WIDTHxHEIGHT, 1 to 32768 pixels each");
  }
  options.width = width;
  options.height = height;
}

void set_window(Options& options, const std::string& text) {
  Window w;
  char rest = 0;
  // NOLINTNEXTLINE(cert-err34-c): four conversions or the text is rejected
  if (std::sscanf(text.c_str(), "%5u,%5u,%5u,%5u%c", &w.x0, &w.y0, &w.x1, &w.y1, &rest) != 4) {
    throw ParameterError("--window", "'" + text + "'", "x0,y0,x1,y1: pixels from the top left corner, x1 and y1 excluded");
  }
  options.window = w;
}

void set_aovs(Options& options, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    const auto [name, file] = split_assignment("--aov", text);
    const auto& known = aov_names();
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      throw ParameterError("--aov", "'" + name + "'", fmt::format("{}", fmt::join(known, ", ")));
    }
    options.aovs[name] = file;
  }
}

template <class T>
void require_range(const char* name, T value, T lo, T hi) {
  require(value >= lo && value <= hi, name, value, fmt::format("{} to {}", lo, hi));
}

/// Options that the method does not have.
void validate_for_method(const Options& o) {
  const char* const method = method_name(o.method);
  const bool many_light = is_many_light(o.method);
  if (o.straight_is_free) require(o.method == Method::path, "--straight-is-free with method", method, "path");
  if (!o.strategy_images.empty()) require(o.method == Method::bdpt, "--strategy-images with method", method, "bdpt");
  if (o.ledger_spp) require(many_light, "--ledger-spp with method", method, "a many-light method");
  if (o.passes > 1) require(many_light, "--passes with method", method, "a many-light method; others take --spp");
  for (const auto& [name, file] : o.aovs) {
    const std::string what = "--aov " + name + " with method";
    if (name == "cut-size") require(has_cuts(o.method), what, method, "lightcuts or bdlc");
    if (name == "missing") require(many_light, what, method, "a many-light method");
  }
  if (!o.compensates) return;
  require(o.method == Method::ir, "--compensate with method", method, "ir; others take --weights kollig_keller");
  if (o.hits_after_dirac_only) {
    throw ParameterError("--compensate", "with --hits-after-dirac-only", "one of the two: the last part of what a clamp "
                         "takes is given back where eye paths meet lamps");
  }
}

void validate(const Options& o) {
  require_range<std::uint32_t>("--spp", o.spp, 1, k_max_samples);
  require_range<std::uint32_t>("--passes", o.passes, 1, k_max_samples);
  require_range<std::uint32_t>("--eye-paths", o.eye_paths, 1, 65536);
  require_range<std::uint64_t>("--photon-paths", o.photon_paths, 1, 500'000'000);
  require_range<std::uint32_t>("--gather-rays", o.gather_rays, 1, 65536);
  require_range<std::uint32_t>("--light-samples", o.light_samples, 1, 65536);
  require_range<std::uint32_t>("--instants", o.instants, 1, 4096);
  require_range<std::uint64_t>("--vpls", o.vpls, 1, 100'000'000);
  require_range<double>("--threshold", o.threshold, 0, 1);
  require_range<std::uint32_t>("--max-cut", o.max_cut, 1, 1U << 30U);
  require_range<std::uint32_t>("--threads", o.threads, 0, 4096);
  require(o.clamp_scale >= 0 && std::isfinite(o.clamp_scale), "--clamp", o.clamp_scale, "finite, at least 0");
  require(o.adaptation_luminance >= 0 && std::isfinite(o.adaptation_luminance), "--adaptation-luminance",
          o.adaptation_luminance, "finite, at least 0");
  require(std::isfinite(o.exposure), "--exposure", o.exposure, "finite");
  if (o.max_depth) require(*o.max_depth == -1 || *o.max_depth >= 1, "--max-depth", *o.max_depth, "-1 or at least 1");
  if (o.ledger_spp) require_range<std::uint32_t>("--ledger-spp", *o.ledger_spp, 2, 1U << 24U);
  const auto require_seconds = [](const char* name, const std::optional<double>& seconds) {
    if (seconds) require(*seconds > 0 && std::isfinite(*seconds), name, *seconds, "above 0 seconds");
  };
  require_seconds("--time-limit", o.time_limit);
  require_seconds("--progress-images", o.progress_images);
}

}  // namespace

const std::vector<std::string>& aov_names() {
  static const std::vector<std::string> names{"albedo", "cut-size", "depth", "missing", "normal"};
  return names;
}

const char* method_name(Method method) {
  switch (method) {
    case Method::path: return "path";
    case Method::bdpt: return "bdpt";
    case Method::pppm: return "pppm";
    case Method::photonmap: return "photonmap";
    case Method::vpl: return "vpl";
    case Method::ir: return "ir";
    case Method::lightcuts: return "lightcuts";
    case Method::bdlc: return "bdlc";
  }
  return "";
}

std::optional<Options> parse_options(int argc, const char* const* argv) {
  Options o;
  std::string size;
  std::string window;
  std::string weights;
  std::vector<std::string> aovs;
  std::vector<std::string> defines;
  CLI::App app{"Renders a scene file (Mitsuba XML subset) with many-light methods.", "manylight-render"};
  const std::map<std::string, Method> methods{
      {"path", Method::path},           {"bdpt", Method::bdpt}, {"pppm", Method::pppm},
      {"photonmap", Method::photonmap}, {"vpl", Method::vpl},   {"ir", Method::ir},
      {"lightcuts", Method::lightcuts}, {"bdlc", Method::bdlc}};
  const std::map<std::string, Weights> weightings{{"standard", Weights::standard},
                                                  {"four", Weights::four},
                                                  {"residual", Weights::residual},
                                                  {"kollig_keller", Weights::kollig_keller},
                                                  {"full", Weights::full}};
  const std::map<std::string, Backend> backends{{"bvh", Backend::bvh}, {"embree", Backend::embree}};
  const std::map<std::string, SamplerKind> samplers{{"independent", SamplerKind::independent},
                                                    {"sobol", SamplerKind::sobol}};
  const std::map<std::string, BoundsKind> bounds_kinds{{"automatic", BoundsKind::automatic},
                                                       {"analytic", BoundsKind::analytic},
                                                       {"cube-map", BoundsKind::cube_map}};
  std::string method = "bdlc";
  std::string bounds = "automatic";
  std::string backend = "bvh";
  std::string sampler = "sobol";
  double time_limit = 0;
  double progress_images = 0;
  int max_depth = 0;
  app.add_option("scene", o.scene, "Scene file, .xml")->required();
  app.add_option("-m,--method", method,
                 "path (reference), bdpt (bidirectional path tracing), pppm (progressive photon mapping), "
                 "photonmap (with final gather), vpl (all pairs), ir (instant radiosity), "
                 "lightcuts (multidimensional), bdlc (bidirectional lightcuts)")
      ->check(CLI::IsMember(methods))->capture_default_str();
  app.add_option("-o,--output", o.outputs, "Image to write: .exr, .pfm (linear) or .png; repeatable")->allow_extra_args(false);
  app.add_option("--size", size, "Image size in pixels, WxH [from the file]");
  app.add_option("--window", window, "Pixels to render, x0,y0,x1,y1 (x1, y1 excluded) [the whole image]");
  auto* spp = app.add_option("--spp", o.spp, "Samples per pixel of path, bdpt and photonmap, passes of pppm "
                                    "[64; with a time limit what it allows]");
  app.add_option("--photon-paths", o.photon_paths, "Light paths that leave photons: of a pass of pppm, of photonmap's map")
      ->capture_default_str();
  app.add_option("--gather-rays", o.gather_rays, "Final gather rays per sample of photonmap")->capture_default_str();
  app.add_option("--light-samples", o.light_samples, "Lights drawn per sample of photonmap")->capture_default_str();
  app.add_option("--instants", o.instants, "Instants of the shutter interval, where something moves")
      ->capture_default_str();
  app.add_option("--eye-paths", o.eye_paths, "Eye paths per pixel and pass of the many-light methods")
      ->capture_default_str();
  auto* passes = app.add_option("--passes", o.passes,
                                "Images, each with lights of its own, that a many-light method takes the mean of "
                                "[1; with a time limit what it allows]");
  app.add_option("--vpls", o.vpls, "Virtual point lights left by light paths; point and directional lights come on top")
      ->capture_default_str();
  app.add_option("--threshold", o.threshold, "Largest error bound of a cluster relative to the pixel, 0 to 1")
      ->capture_default_str();
  app.add_option("--max-cut", o.max_cut, "Most clusters in a pixel's cut")->capture_default_str();
  auto* depth = app.add_option("--max-depth", max_depth, "Longest path in edges, -1: unlimited [from the file]");
  app.add_flag("--straight-is-free", o.straight_is_free,
               "Light straight through a thin pane costs no edge of --max-depth (method path)");
  app.add_option("--backend", backend, "Ray tracer: bvh (built in) or embree")
      ->check(CLI::IsMember(backends))->capture_default_str();
  app.add_option("--sampler", sampler, "Random numbers: sobol (Owen-scrambled) or independent")
      ->check(CLI::IsMember(samplers))->capture_default_str();
  app.add_option("--filter", o.filter, "Reconstruction filter: box, tent or gaussian [from the file]")
      ->check(CLI::IsMember({"box", "tent", "gaussian"}));
  app.add_option("--seed", o.seed, "Seed; the same seed gives the same image, whatever the threads")
      ->capture_default_str();
  app.add_option("--threads", o.threads, "Threads, 0: all")->capture_default_str();
  auto* limit = app.add_option("--time-limit", time_limit, "Seconds of rendering; the first pass is always finished");
  auto* progress = app.add_option("--progress-images", progress_images,
                                  "Write the image so far to the outputs about every so many seconds, between passes");
  auto* chosen_weights =
      app.add_option("--weights", weights, "Weights of the pairs [four for bdlc, standard for vpl and lightcuts]")
          ->check(CLI::IsMember(weightings));
  app.add_flag("--compensate", o.compensates,
               "Method ir: give back what the clamp takes, without bias, by going on with eye paths")
      ->excludes(chosen_weights);
  app.add_option("--bounds", bounds,
                 "Bounds of materials in cuts: automatic (from eval), analytic (closed forms), cube-map (of the former)")
      ->check(CLI::IsMember(bounds_kinds))->capture_default_str();
  app.add_option("--clamp", o.clamp_scale, "C_clamp = this x L_a / I_avg; 0: no clamp")->capture_default_str();
  app.add_option("--adaptation-luminance", o.adaptation_luminance, "L_a in W/m^2/sr, 0: estimated")
      ->capture_default_str();
  app.add_flag("--hits-after-dirac-only", o.hits_after_dirac_only,
               "Count emitters met by eye paths only when seen directly or through mirrors and glass");
  app.add_option("--ledger-spp", o.ledger_spp,
                 "Samples per pixel of the ledger of missing energy [64 with --aov missing]");
  app.add_option("--stats", o.stats, "Write statistics as JSON to this file");
  app.add_option("--aov", aovs,
                 "Write an auxiliary image, NAME=FILE: albedo, cut-size, depth (m), missing (W/m^2/sr), normal; repeatable")
      ->allow_extra_args(false);
  app.add_option("--strategy-images", o.strategy_images,
                 "Write the weighted image of each strategy of bdpt to this folder, for paths of up to 8 edges");
  app.add_option("-D", defines, "Set a $parameter of the scene file, name=value; repeatable")->allow_extra_args(false);
  app.add_option("--exposure", o.exposure, "Stops by which PNG output is brightened")->capture_default_str();
  app.add_flag("--lenient", o.lenient, "Replace unknown materials by grey diffuse ones, with a warning each");
  app.add_flag("-q,--quiet", o.quiet, "Print nothing but errors");
  app.set_version_flag("--version", fmt::format("manylight-render {}.{}.{}", MANYLIGHT_VERSION_MAJOR,
                                                MANYLIGHT_VERSION_MINOR, MANYLIGHT_VERSION_PATCH));
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& request) {
    app.exit(request);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    throw Error(error.what());
  }
  o.method = methods.at(method);
  o.backend = backends.at(backend);
  o.sampler = samplers.at(sampler);
  o.bounds = bounds_kinds.at(bounds);
  if (limit->count() > 0) o.time_limit = time_limit;
  if (progress->count() > 0) o.progress_images = progress_images;
  if (o.time_limit && spp->count() == 0) o.spp = k_max_samples;
  if (o.time_limit && passes->count() == 0 && is_many_light(o.method)) o.passes = k_max_samples;
  if (depth->count() > 0) o.max_depth = max_depth;
  if (!size.empty()) set_size(o, size);
  if (!window.empty()) set_window(o, window);
  if (o.method == Method::ir) {
    require(weights.empty(), "--weights with method", "ir", "method vpl, which is ir with any weights");
    o.weights = o.compensates ? Weights::kollig_keller : Weights::standard;
  } else {
    o.weights = !weights.empty() ? weightings.at(weights) : o.method == Method::bdlc ? Weights::four : Weights::standard;
  }
  set_aovs(o, aovs);
  for (const std::string& define : defines) o.defines.insert(split_assignment("-D", define));
  if (o.aovs.contains("missing") && !o.ledger_spp) o.ledger_spp = 64;
  if (o.outputs.empty()) o.outputs.emplace_back("render.exr");
  validate(o);
  validate_for_method(o);
  return o;
}

}  // namespace manylight::render
