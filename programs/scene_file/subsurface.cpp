// SPDX-License-Identifier: Apache-2.0
// <subsurface> elements.
#include <algorithm>

#include "scene_file/context.hpp"

namespace manylight::scene_file {

namespace {

Rgb<float> take_positive(Context& context, Properties& p, const char* name) {
  const Rgb<float> value = take_color(context, p, name, SpectrumRole::parameter, Rgb<float>(0));
  if (!(std::min({value.x, value.y, value.z}) > 0)) {
    fail(p.element(), std::string(name) + " must be above 0 in each channel");
  }
  return value;
}

/// Diffusion by dipoles, of the coefficients in 1 / m after `scale`.
void take_dipole(Context& context, Properties& p, SubsurfaceDescription& d) {
  const auto scale = static_cast<float>(p.positive("scale", 1.0));
  const double g = p.number("g", 0.0);
  if (!(g > -1 && g < 1)) fail(p.element(), "g is out of range, allowed: above -1, below 1");
  d.sigma_s = take_positive(context, p, "sigma_s") * (scale * static_cast<float>(1 - g));  // reduced
  d.sigma_a = take_color(context, p, "sigma_a", SpectrumRole::parameter, Rgb<float>(0)) * scale;
}

}  // namespace

SubsurfaceDescription parse_subsurface(Context& context, const Element& element) {
  const std::string& type = element.get("type");
  Properties p(element, context.names);
  SubsurfaceDescription d;
  d.name = element.has("id") ? element.get("id") : element.describe();
  const bool has_glass = type == "dipole";  // unless the file says otherwise
  d.ior = static_cast<float>(p.positive("int_ior", has_glass ? 1.5046 : 1.0) /
                             p.positive("ext_ior", has_glass ? 1.000277 : 1.0));
  if (type == "dipole") {
    d.kind = FalloffKind::dipole;
    take_dipole(context, p, d);
  } else if (type == "exponential" || type == "gaussian" || type == "burley") {
    d.kind = type == "exponential" ? FalloffKind::exponential
             : type == "gaussian"  ? FalloffKind::gaussian
                                   : FalloffKind::burley;
    d.length = take_positive(context, p, "length");
    d.reflectance = take_color(context, p, "reflectance", SpectrumRole::ratio, Rgb<float>(0.8F));
    if (max_channel(d.reflectance) > 1) fail(element, "reflectance is above 1, allowed: 0 to 1");
  } else {
    fail(element, "unknown subsurface scattering; supported are dipole, exponential, gaussian and burley");
  }
  p.ignore({"irr_samples"});
  p.finish();
  return d;
}

}  // namespace manylight::scene_file
