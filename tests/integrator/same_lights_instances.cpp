// SPDX-License-Identifier: Apache-2.0
#include "integrator/same_lights.hpp"

namespace manylight::test {
template class SameLights<DiffuseScene<Bvh<float>>>;
template class SameLights<DiffuseScene<Bvh<double>>>;
}  // namespace manylight::test
