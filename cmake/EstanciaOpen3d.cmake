# Open3D aligns and optimises for odometry. It is optional, and since it loads a hundred libraries, what uses it is a
# module of its own that odometry/open3d.cpp opens when it is first needed: no other command waits for it, and nobody
# who links Estancia links Open3D.
option(ESTANCIA_OPEN3D "Build odometry, where Open3D is installed" ON)
list(FILTER ESTANCIA_SOURCES EXCLUDE REGEX "/open3d_module\\.cpp$")

function(estancia_use_open3d)
  if(ESTANCIA_OPEN3D)
    find_package(Open3D QUIET CONFIG)
    find_package(TBB QUIET CONFIG)
    find_package(OpenMP QUIET COMPONENTS CXX)
  endif()
  if(NOT TARGET Open3D::Open3D OR NOT TARGET TBB::tbb OR NOT TARGET OpenMP::OpenMP_CXX)
    message(STATUS "Open3D: none found, there will be no odometry; script/bootstrap installs it")
    return()
  endif()
  message(STATUS "Open3D: ${Open3D_VERSION}")
  set(module_folder ${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR})
  add_library(estancia_open3d MODULE ${PROJECT_SOURCE_DIR}/estancia/odometry/open3d_module.cpp)
  estancia_defaults(estancia_open3d)
  set_target_properties(estancia_open3d PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${module_folder} CXX_VISIBILITY_PRESET hidden)
  if(ESTANCIA_SANITIZE)
    # Under the address sanitizer Eigen would manage memory in another way than the Open3D that it is handed to.
    target_compile_definitions(estancia_open3d PRIVATE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  endif()
  target_include_directories(estancia_open3d PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(estancia_open3d PRIVATE Open3D::Open3D TBB::tbb OpenMP::OpenMP_CXX opencv_core)
  add_dependencies(estancia estancia_open3d)
  file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_source_files_properties(
    estancia/odometry/open3d.cpp
    PROPERTIES COMPILE_DEFINITIONS
               "ESTANCIA_OPEN3D_MODULE=\"$<TARGET_FILE_NAME:estancia_open3d>\";ESTANCIA_OPEN3D_FROM_BIN=\"${from_bin}\"")
  target_link_libraries(estancia PRIVATE ${CMAKE_DL_LIBS})
  install(TARGETS estancia_open3d LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()
