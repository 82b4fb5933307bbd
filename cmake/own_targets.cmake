# SPDX-License-Identifier: Apache-2.0
# What our own programs, tests, examples and benchmarks share: warnings, processor, sanitizers.

add_library(manylight_warnings INTERFACE)
target_compile_options(manylight_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  # g++ 12 invents overlapping copies in "literal" + std::string (GCC bug 105651).
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>:-Wno-restrict>
  $<$<BOOL:${MANYLIGHT_WARNINGS_AS_ERRORS}>:-Werror>)

add_library(manylight_own INTERFACE)
target_link_libraries(manylight_own INTERFACE manylight::manylight manylight_warnings)
target_compile_options(manylight_own INTERFACE $<$<BOOL:${MANYLIGHT_NATIVE}>:-march=native>)
if(MANYLIGHT_SANITIZE)
  # -O1: sanitized tests at -O0 would take minutes. No recovery: the first finding ends the test as failed.
  set(sanitize -O1 -fno-omit-frame-pointer -fsanitize=${MANYLIGHT_SANITIZE} -fno-sanitize-recover=all)
  target_compile_options(manylight_own INTERFACE ${sanitize})
  target_link_options(manylight_own INTERFACE ${sanitize})
endif()

# Links `target` with the optional packages that were found; its code asks MANYLIGHT_HAS_TBB / MANYLIGHT_HAS_EMBREE.
function(manylight_link_optional target)
  foreach(suffix IN ITEMS TBB EMBREE)
    if(MANYLIGHT_HAS_${suffix})
      string(TOLOWER ${suffix} name)
      target_link_libraries(${target} PRIVATE manylight::${name})
      target_compile_definitions(${target} PRIVATE MANYLIGHT_HAS_${suffix}=1)
    endif()
  endforeach()
endfunction()
