# SPDX-License-Identifier: Apache-2.0
# cmake --install, and find_package(estancia [COMPONENTS room…]) → estancia::room, estancia::estancia
# (tests/find_package proves it)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/estancia)
get_target_property(library_type estancia_core TYPE)
if(library_type STREQUAL "STATIC_LIBRARY")
  set(ESTANCIA_IS_STATIC TRUE)
else()
  set(ESTANCIA_IS_STATIC FALSE)
endif()

# An installed command finds the shared library beside it, wherever the prefix is moved to.
file(RELATIVE_PATH bin_to_lib ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
# The build tree is laid out alike. (A path of its own would be padded, and looked up in the folder it is run in.)
set_target_properties(estancia_command PROPERTIES INSTALL_RPATH $ORIGIN/${bin_to_lib} BUILD_WITH_INSTALL_RPATH ON)

include(EstanciaFormer)
list(TRANSFORM ESTANCIA_FORMER_ROOMS PREPEND estancia_ OUTPUT_VARIABLE former)
install(TARGETS estancia ${ESTANCIA_LIBRARIES} ${former} EXPORT estanciaTargets FILE_SET HEADERS)
install(TARGETS estancia_command)
# estancia-fetch: script/bootstrap --networks, and the models' descriptions that it needs.
set(shared ${CMAKE_INSTALL_DATADIR}/estancia)
file(RELATIVE_PATH bin_to_share ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_DATADIR}/estancia)
configure_file(${PROJECT_SOURCE_DIR}/cmake/estancia-fetch.in ${PROJECT_BINARY_DIR}/estancia-fetch @ONLY)
install(PROGRAMS ${PROJECT_BINARY_DIR}/estancia-fetch DESTINATION ${CMAKE_INSTALL_BINDIR})
install(PROGRAMS ${PROJECT_SOURCE_DIR}/script/bootstrap DESTINATION ${shared}/script)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/models DESTINATION ${shared} PATTERN catalog.toml EXCLUDE PATTERN priors EXCLUDE)
# Man pages and shell completion, as the command itself writes them.
set(pages ${PROJECT_BINARY_DIR}/pages)
install(CODE "
  set(command ${CMAKE_CROSSCOMPILING_EMULATOR} \"$<TARGET_FILE:estancia_command>\")
  file(MAKE_DIRECTORY \"${pages}\")
  execute_process(COMMAND \${command} generate man -o \"${pages}/man1\" --overwrite COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND \${command} generate bash OUTPUT_FILE \"${pages}/estancia\" COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND \${command} generate zsh OUTPUT_FILE \"${pages}/_estancia\" COMMAND_ERROR_IS_FATAL ANY)")
install(DIRECTORY ${pages}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR})
install(FILES ${pages}/estancia DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${pages}/_estancia DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
# The laboratory (lab/) and nobody else: all headers and what the command's programs share, without any promise that they
# stay as they are. cmake --install build --component internal; find_package(estancia COMPONENTS internal)
set(internal COMPONENT internal EXCLUDE_FROM_ALL)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/estancia DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${internal}
        FILES_MATCHING PATTERN "*.hpp")
install(FILES apps/command_line.hpp apps/declared_options.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/estancia/apps ${internal})
set_target_properties(estancia_command_line PROPERTIES EXPORT_NAME command_line)
install(TARGETS estancia_command_line EXPORT estanciaInternalTargets ARCHIVE ${internal})
install(EXPORT estanciaInternalTargets NAMESPACE estancia:: DESTINATION ${package_folder} ${internal})
install(EXPORT estanciaTargets NAMESPACE estancia:: DESTINATION ${package_folder})
get_property(ESTANCIA_NEEDS GLOBAL PROPERTY ESTANCIA_NEEDS)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/estanciaConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/estanciaConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/estanciaConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/estanciaConfig.cmake ${PROJECT_BINARY_DIR}/estanciaConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindSvm.cmake ${PROJECT_SOURCE_DIR}/cmake/FindLinear.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindLz4.cmake ${PROJECT_SOURCE_DIR}/cmake/FindZstd.cmake
        DESTINATION ${package_folder})
