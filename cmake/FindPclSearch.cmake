# Finds PCL's headers and its small libraries (libpcl-dev): the target PclSearch::PclSearch.
# PCL's own package would bring features and keypoints as libraries of many megabytes, whose loading costs every command
# 30 ms; what recognition uses of them is compiled from PCL's templates instead (recognition/pcl.hpp).
find_path(PclSearch_INCLUDE_DIR pcl/point_cloud.h PATH_SUFFIXES pcl-1.15 pcl-1.14 pcl-1.13 pcl-1.12)
find_path(PclSearch_EIGEN_INCLUDE_DIR Eigen/Core PATH_SUFFIXES eigen3)
set(PclSearch_libraries)
foreach(part search kdtree octree common)
  find_library(PclSearch_${part}_LIBRARY pcl_${part})
  mark_as_advanced(PclSearch_${part}_LIBRARY)
  list(APPEND PclSearch_libraries ${PclSearch_${part}_LIBRARY})
endforeach()
mark_as_advanced(PclSearch_INCLUDE_DIR PclSearch_EIGEN_INCLUDE_DIR)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  PclSearch
  REQUIRED_VARS PclSearch_search_LIBRARY PclSearch_kdtree_LIBRARY PclSearch_octree_LIBRARY PclSearch_common_LIBRARY
                PclSearch_INCLUDE_DIR PclSearch_EIGEN_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "install libpcl-dev")
if(PclSearch_FOUND AND NOT TARGET PclSearch::PclSearch)
  add_library(PclSearch::PclSearch INTERFACE IMPORTED)
  set_target_properties(PclSearch::PclSearch PROPERTIES
    INTERFACE_LINK_LIBRARIES "${PclSearch_libraries}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${PclSearch_INCLUDE_DIR};${PclSearch_EIGEN_INCLUDE_DIR}"
    INTERFACE_INCLUDE_DIRECTORIES "${PclSearch_INCLUDE_DIR};${PclSearch_EIGEN_INCLUDE_DIR}")
endif()
