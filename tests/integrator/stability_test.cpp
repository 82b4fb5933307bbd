// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/bvh.hpp"

#include "integrator/stability_suite.hpp"

namespace manylight::test {
INSTANTIATE_TYPED_TEST_SUITE_P(BvhFloat, StabilitySuite, Bvh<float>);
INSTANTIATE_TYPED_TEST_SUITE_P(BvhDouble, StabilitySuite, Bvh<double>);
}  // namespace manylight::test
