// SPDX-License-Identifier: Apache-2.0
#include "manylight/geometry/bvh.hpp"

#include "integrator/analytic_suite.hpp"

namespace manylight::test {
INSTANTIATE_TYPED_TEST_SUITE_P(BvhFloat, AnalyticSuite, Bvh<float>);
INSTANTIATE_TYPED_TEST_SUITE_P(BvhDouble, AnalyticSuite, Bvh<double>);
}  // namespace manylight::test
