// SPDX-License-Identifier: Apache-2.0
// The main function of all test programs: with the reference scenes at hand nothing is excused, a skipped test fails.
#include <gtest/gtest.h>

namespace {

class SkipIsFailure : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo& test) override {
    if (test.result()->Skipped()) ADD_FAILURE() << "skipped, although MANYLIGHT_REFERENCE_SCENES is set";
  }
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  if (MANYLIGHT_REFERENCE_SCENES[0] != '\0') testing::UnitTest::GetInstance()->listeners().Append(new SkipIsFailure);
  return RUN_ALL_TESTS();
}
