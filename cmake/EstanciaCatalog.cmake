# The model catalog, compiled into the library so that an installed command needs no file beside it.
set(catalog ${PROJECT_SOURCE_DIR}/models/catalog.toml)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${catalog})
file(READ ${catalog} MODEL_CATALOG)
configure_file(${PROJECT_SOURCE_DIR}/cmake/model_catalog.cpp.in ${PROJECT_BINARY_DIR}/model_catalog.cpp @ONLY)
target_sources(estancia PRIVATE ${PROJECT_BINARY_DIR}/model_catalog.cpp)
