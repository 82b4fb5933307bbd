// SPDX-License-Identifier: Apache-2.0
#include <iostream>

#include "compare/compare.hpp"

int main(int argc, char** argv) { return manylight::compare::run_compare(argc, argv, std::cout, std::cerr); }
