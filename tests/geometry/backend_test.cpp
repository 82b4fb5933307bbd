// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/bvh.hpp"

#include "geometry/backend_suite.hpp"

namespace manylight::test {
INSTANTIATE_TYPED_TEST_SUITE_P(BvhFloat, BackendSuite, Bvh<float>);
INSTANTIATE_TYPED_TEST_SUITE_P(BvhDouble, BackendSuite, Bvh<double>);
}  // namespace manylight::test
