// SPDX-License-Identifier: Apache-2.0
#include "integrator/common_scenes.hpp"

namespace manylight::test {
MANYLIGHT_TEST_RENDER(DiffuseScene<Bvh<float>>);
MANYLIGHT_TEST_RENDER(DiffuseScene<Bvh<double>>);
}  // namespace manylight::test
