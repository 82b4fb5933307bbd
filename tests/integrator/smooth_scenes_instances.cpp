// SPDX-License-Identifier: Apache-2.0
#include "integrator/common_scenes.hpp"

namespace manylight::test {
MANYLIGHT_TEST_RENDER(SmoothScene<Bvh<float>>);
MANYLIGHT_TEST_RENDER(SmoothScene<Bvh<double>>);
}  // namespace manylight::test
