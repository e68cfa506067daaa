# The model catalogue, compiled into the library so that an installed command needs no file beside it.
set(catalogue ${PROJECT_SOURCE_DIR}/models/catalogue.toml)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${catalogue})
file(READ ${catalogue} MODEL_CATALOGUE)
configure_file(${PROJECT_SOURCE_DIR}/cmake/model_catalogue.cpp.in ${PROJECT_BINARY_DIR}/model_catalogue.cpp @ONLY)
target_sources(estancia PRIVATE ${PROJECT_BINARY_DIR}/model_catalogue.cpp)
