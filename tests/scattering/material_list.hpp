// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "manylight/scattering/any_of.hpp"
#include "manylight/scattering/conductor.hpp"
#include "manylight/scattering/dielectric.hpp"
#include "manylight/scattering/lambertian.hpp"
#include "manylight/scattering/metals.hpp"
#include "manylight/scattering/mixture.hpp"
#include "manylight/scattering/oren_nayar.hpp"
#include "manylight/scattering/phong.hpp"
#include "manylight/scattering/plastic.hpp"
#include "manylight/scattering/retro_phong.hpp"
#include "manylight/scattering/rough_dielectric.hpp"
#include "manylight/scattering/rough_plastic.hpp"
#include "manylight/scattering/ward.hpp"

namespace manylight::test {

/// Coats shared by the tests; built once.
template <std::floating_point S>
const RoughTransmittance<S>& coat_ggx() {
  static const RoughTransmittance<S> table(MicrofacetType::ggx, S(0.15), S(1.5));
  return table;
}
template <std::floating_point S>
const RoughTransmittance<S>& coat_rough_ggx() {
  static const RoughTransmittance<S> table(MicrofacetType::ggx, S(0.6), S(1.9));
  return table;
}
template <std::floating_point S>
const RoughTransmittance<S>& coat_beckmann() {
  static const RoughTransmittance<S> table(MicrofacetType::beckmann, S(0.3), S(1.33));
  return table;
}

template <std::floating_point S>
using AnyMaterial = AnyOf<Lambertian<S>, Mixture<Lambertian<S>, Ward<S>>, RoughPlastic<S>, Mirror<S>>;

/// Calls `visit(name, material)` with every material that has a part to connect: at least three parameter sets of each,
/// smooth to rough, isotropic and not, coloured.
template <std::floating_point S, class Visit>
void for_each_material(const Visit& visit) {
  using MT = MicrofacetType;
  const Rgb<S> red(S(0.9), S(0.3), S(0.1));
  const Rgb<S> white(S(1));
  const Metal<S> copper = *find_metal<S>("Cu");
  visit("Lambertian red", Lambertian<S>{red});
  visit("Lambertian white", Lambertian<S>{white});
  visit("Lambertian grey", Lambertian<S>{Rgb<S>(S(0.2))});
  visit("Phong 0", Phong<S>{red, S(0)});
  visit("Phong 10", Phong<S>{white, S(10)});
  visit("Phong 100", Phong<S>{red, S(100)});
  visit("RetroPhong 0", RetroPhong<S>{red, S(0)});
  visit("RetroPhong 5", RetroPhong<S>{white, S(5)});
  visit("RetroPhong 200", RetroPhong<S>{red, S(200)});
  visit("Ward .05", Ward<S>{white, S(0.05), S(0.05)});
  visit("Ward .1 .4", Ward<S>{red, S(0.1), S(0.4)});
  visit("Ward 1", Ward<S>{white, S(1), S(1)});
  visit("Ward original .2", Ward<S>{white, S(0.2), S(0.2), WardVariant::original});
  visit("Ward Duer .2", Ward<S>{white, S(0.2), S(0.2), WardVariant::duer});
  visit("OrenNayar .1", OrenNayar<S>{white, S(0.1)});
  visit("OrenNayar .5", OrenNayar<S>{red, S(0.5)});
  visit("OrenNayar 1 short", OrenNayar<S>{red, S(1), OrenNayarModel::qualitative});
  visit("Conductor Beckmann .05", RoughConductor<S>{MT::beckmann, S(0.05), S(0.05), copper.eta, copper.k, white});
  visit("Conductor Beckmann .1 .4", RoughConductor<S>{MT::beckmann, S(0.1), S(0.4)});
  visit("Conductor Beckmann 1.5", RoughConductor<S>{MT::beckmann, S(1.5), S(1.5)});
  visit("Conductor GGX .05", RoughConductor<S>{MT::ggx, S(0.05), S(0.05), copper.eta, copper.k, red});
  visit("Conductor GGX .4 .1", RoughConductor<S>{MT::ggx, S(0.4), S(0.1)});
  visit("Conductor GGX 1", RoughConductor<S>{MT::ggx, S(1), S(1)});
  visit("Conductor GGX 1.6 .7", RoughConductor<S>{MT::ggx, S(1.6), S(0.7)});
  visit("Plastic", Plastic<S>(red, white, S(1.5)));
  visit("Plastic nonlinear", Plastic<S>(red, red, S(1.9), CoatedBase::nonlinear));
  visit("Plastic white", Plastic<S>(white, white, S(1.33)));
  visit("RoughPlastic GGX .15", RoughPlastic<S>{&coat_ggx<S>(), red, white, CoatedBase::nonlinear});
  visit("RoughPlastic GGX .6", RoughPlastic<S>{&coat_rough_ggx<S>(), white, white});
  visit("RoughPlastic Beckmann .3", RoughPlastic<S>{&coat_beckmann<S>(), Rgb<S>(S(0.3)), red});
  visit("Mixture diffuse Phong",
        Mixture<Lambertian<S>, Phong<S>>({Lambertian<S>{red}, S(0.5)}, {Phong<S>{white, S(60)}, S(0.5)}));
  visit("Mixture diffuse mirror Ward",
        Mixture<Lambertian<S>, Mirror<S>, Ward<S>>({Lambertian<S>{red}, S(0.3)}, {Mirror<S>{white}, S(0.2)},
                                                   {Ward<S>{white, S(0.1), S(0.3)}, S(0.5)}));
  visit("Mixture of coats", Mixture<Plastic<S>, RoughConductor<S>>({Plastic<S>(red, white, S(1.5)), S(0.6)},
                                                                   {RoughConductor<S>{}, S(0.4)}));
  visit("AnyOf mixture", AnyMaterial<S>(Mixture<Lambertian<S>, Ward<S>>({Lambertian<S>{red}, S(0.4)},
                                                                        {Ward<S>{white, S(0.2), S(0.2)}, S(0.6)})));
  visit("AnyOf coat", AnyMaterial<S>(RoughPlastic<S>{&coat_ggx<S>(), red, white}));
}

}  // namespace manylight::test
