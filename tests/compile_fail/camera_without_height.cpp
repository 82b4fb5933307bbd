// SPDX-License-Identifier: Apache-2.0
// expect: Camera
// expect: camera.height..[^ ]+ (is|would be) invalid
#ifndef MANYLIGHT_CORRECT
#define WITHOUT_HEIGHT
#endif
#include "pinhole.hpp"

int main() { return manylight::Window::of(Pinhole{}).pixel_count() == 1 ? 0 : 1; }
