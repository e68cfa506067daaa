# make install, and find_package(estancia) → estancia::estancia
install(TARGETS estancia EXPORT estanciaTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(TARGETS estancia_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/estancia DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.hpp")
install(EXPORT estanciaTargets NAMESPACE estancia:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/estancia)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/estanciaConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/estanciaConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/estancia)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/estanciaConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/estanciaConfig.cmake ${PROJECT_BINARY_DIR}/estanciaConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/estancia)
