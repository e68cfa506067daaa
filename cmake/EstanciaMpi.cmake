# Experiments on several machines talk through Open MPI. It is optional, and what uses it is a module of its own that
# experiment/ranks.cpp opens when mpirun has started the command: nobody else loads MPI, and nobody who links Estancia
# links it.
option(ESTANCIA_MPI "Run experiments under mpirun, where Open MPI is installed" ON)
list(FILTER ESTANCIA_SOURCES EXCLUDE REGEX "/ranks_module\\.cpp$")

function(estancia_use_mpi)
  if(ESTANCIA_MPI)
    find_package(MPI QUIET COMPONENTS C)
  endif()
  if(NOT TARGET MPI::MPI_C)
    message(STATUS "Open MPI: none found, experiments will run on one machine; script/bootstrap installs it")
    return()
  endif()
  set(module_folder ${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR})
  add_library(estancia_mpi MODULE ${PROJECT_SOURCE_DIR}/estancia/experiment/ranks_module.cpp)
  estancia_defaults(estancia_mpi)
  set_target_properties(estancia_mpi PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${module_folder} CXX_VISIBILITY_PRESET hidden)
  target_include_directories(estancia_mpi PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(estancia_mpi PRIVATE MPI::MPI_C)
  add_dependencies(estancia estancia_mpi)
  file(RELATIVE_PATH from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_source_files_properties(
    estancia/experiment/ranks.cpp
    PROPERTIES COMPILE_DEFINITIONS
               "ESTANCIA_MPI_MODULE=\"$<TARGET_FILE_NAME:estancia_mpi>\";ESTANCIA_MPI_FROM_BIN=\"${from_bin}\"")
  target_link_libraries(estancia PRIVATE ${CMAKE_DL_LIBS})
  install(TARGETS estancia_mpi LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endfunction()
