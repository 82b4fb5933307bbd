# SPDX-License-Identifier: Apache-2.0
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)

set(package_folder "${CMAKE_INSTALL_DATADIR}/cmake/manylight")
install(DIRECTORY include/manylight TYPE INCLUDE FILES_MATCHING PATTERN "*.hpp")
install(TARGETS manylight EXPORT manylight_targets)
install(EXPORT manylight_targets NAMESPACE manylight:: FILE manylightTargets.cmake DESTINATION "${package_folder}")
configure_package_config_file(cmake/manylightConfig.cmake.in "${PROJECT_BINARY_DIR}/manylightConfig.cmake"
  INSTALL_DESTINATION "${package_folder}" NO_SET_AND_CHECK_MACRO)
# Headers only: the same package serves every processor. Before 1.0, a minor version may break users.
write_basic_package_version_file("${PROJECT_BINARY_DIR}/manylightConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES "${PROJECT_BINARY_DIR}/manylightConfig.cmake" "${PROJECT_BINARY_DIR}/manylightConfigVersion.cmake"
  cmake/bridges.cmake DESTINATION "${package_folder}")
install(FILES LICENSE README.md CHANGELOG.md TYPE DOC)

foreach(program IN ITEMS manylight-render manylight-compare)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME)
  endif()
endforeach()
if(TARGET manylight-render)
  install(PROGRAMS programs/chart/manylight-chart TYPE BIN)
  install(DIRECTORY programs/chart/ DESTINATION "${CMAKE_INSTALL_DATADIR}/manylight/chart" FILES_MATCHING PATTERN "*.py")
endif()
