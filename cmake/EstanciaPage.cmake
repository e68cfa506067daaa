# The pages' styles and script, compiled into the library so that a page needs no files beside it.
function(estancia_embed target)
  set(folder ${PROJECT_SOURCE_DIR}/estancia/report)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder}/map_page.css ${folder}/map_page.js
               ${folder}/findings_page.css)
  file(READ ${folder}/map_page.css MAP_PAGE_CSS)
  file(READ ${folder}/map_page.js MAP_PAGE_SCRIPT)
  file(READ ${folder}/findings_page.css FINDINGS_PAGE_CSS)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/map_page_assets.cpp.in ${PROJECT_BINARY_DIR}/map_page_assets.cpp @ONLY)
  target_sources(${target} PRIVATE ${PROJECT_BINARY_DIR}/map_page_assets.cpp)
endfunction()
estancia_embed(estancia)
