// SPDX-License-Identifier: Apache-2.0
// expect: photon mapping with final gather knows no participating media
#include "manylight/integrator/photon_map.hpp"
#include "manylight/media/homogeneous.hpp"
#include "manylight/scattering/isotropic_phase.hpp"
#include "surface.hpp"

#ifdef MANYLIGHT_CORRECT
using Media = manylight::NoMedia;
#else
using Media = manylight::SceneMedia<manylight::Homogeneous<manylight::IsotropicPhase<float>>>;
#endif
using FogScene = manylight::Scene<manylight::Bvh<float>, Surface, Media>;

std::size_t size() { return sizeof(manylight::PhotonMapIntegrator<FogScene>); }
