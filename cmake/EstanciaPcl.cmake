# SPDX-License-Identifier: Apache-2.0
# The Point Cloud Library, beside which tests and benchmarks measure ours; the library itself does not need it.
# estancia_use_pcl(target): defines ESTANCIA_HAS_PCL where it is at hand.
include_guard()
find_package(PCL 1.12 QUIET COMPONENTS common features filters keypoints registration search segmentation)
if(NOT PCL_FOUND)
  message(STATUS "PCL not found: nothing is compared with it (libpcl-dev)")
endif()

function(estancia_use_pcl target)
  if(PCL_FOUND)
    target_include_directories(${target} SYSTEM PRIVATE ${PCL_INCLUDE_DIRS})
    target_compile_definitions(${target} PRIVATE ESTANCIA_HAS_PCL)
    if(ESTANCIA_SANITIZE) # PCL frees as malloc aligned it; Eigen's headers would do otherwise beside a sanitizer
      target_compile_definitions(${target} PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1)
    endif()
    target_link_libraries(${target} PRIVATE ${PCL_COMMON_LIBRARIES} ${PCL_FEATURES_LIBRARIES} ${PCL_FILTERS_LIBRARIES}
                                            ${PCL_KEYPOINTS_LIBRARIES} ${PCL_REGISTRATION_LIBRARIES} ${PCL_SEARCH_LIBRARIES}
                                            ${PCL_SEGMENTATION_LIBRARIES})
  endif()
endfunction()
