# SPDX-License-Identifier: Apache-2.0
# Debian 12 packages, sourced by tests/run.sh and examples/demo.sh.
packages_program=(g++ cmake ninja-build libglm-dev libnanoflann-dev libtbb-dev libpugixml-dev
  libassimp-dev libopenexr-dev libstb-dev libcli11-dev nlohmann-json3-dev libfmt-dev zlib1g-dev)
packages_tests=(libembree-dev libnanovdb-dev libgtest-dev libgmock-dev libbenchmark-dev ccache python3 python3-matplotlib)
packages_ci=(clang)
