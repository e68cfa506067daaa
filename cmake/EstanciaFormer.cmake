# SPDX-License-Identifier: Apache-2.0
# Rooms that were split, for one minor version: whoever names them as components, or includes public headers by their
# old paths, gets the rooms that hold their contents now. FORMER_NAME are the rooms that NAME was split into.
set(ESTANCIA_FORMER_stats distances)
set(ESTANCIA_FORMER_io files sequences readers)
set(ESTANCIA_FORMER_label labelers)
set(ESTANCIA_FORMER_cloud segmentation)
set(ESTANCIA_FORMER_topology map_file mapper localization session query)
set(ESTANCIA_FORMER_world world_file layers world_query joining)
set(ESTANCIA_FORMER_report figures)
set(ESTANCIA_FORMER_live sources site)
set(split stats io label cloud topology world report live)

# Components: io and topology are no rooms any more. Of the others, cmake/estanciaConfig.cmake.in adds what was split off.
set(ESTANCIA_FORMER_ROOMS io topology)
set(ESTANCIA_FORMER "")
foreach(room IN LISTS split)
  string(APPEND ESTANCIA_FORMER "set(estancia_former_${room} ${ESTANCIA_FORMER_${room}})\n")
endforeach()
foreach(room IN LISTS ESTANCIA_FORMER_ROOMS)
  add_library(estancia_${room} INTERFACE)
  add_library(estancia::${room} ALIAS estancia_${room})
  set_target_properties(estancia_${room} PROPERTIES EXPORT_NAME ${room})
  list(TRANSFORM ESTANCIA_FORMER_${room} PREPEND estancia_ OUTPUT_VARIABLE parts)
  target_link_libraries(estancia_${room} INTERFACE ${parts})
endforeach()

# Headers: one at each old path says where it is now.
set(forwarding ${PROJECT_BINARY_DIR}/forwarding)
foreach(room IN LISTS split)
  foreach(part IN LISTS ESTANCIA_FORMER_${room})
    set(headers ${ESTANCIA_HEADERS})
    list(FILTER headers INCLUDE REGEX "/estancia/${part}/")
    foreach(header IN LISTS headers)
      get_filename_component(name ${header} NAME)
      set(now estancia/${part}/${name})
      set(more "")
      if(name STREQUAL "sequence.hpp") # openSequence() stood there, too
        set(more "#include <estancia/readers/open_sequence.hpp>\n")
      elseif(name STREQUAL "map.hpp") # writeRoomPredictions()
        set(more "#include <estancia/session/session.hpp>\n")
      endif()
      file(CONFIGURE OUTPUT ${forwarding}/estancia/${room}/${name}
           CONTENT "#pragma once\n#pragma message(\"estancia/${room}/${name} is now ${now}\")\n#include <${now}>\n${more}")
    endforeach()
  endforeach()
endforeach()
# Headers that were merged into others, at each path that they had.
set(ESTANCIA_MERGED
    core/choice core/options
    core/label_probability core/vocabulary
    core/planar_pose core/pose
    core/rigid core/pose
    words/naming_options words/installed_words
    label/label_cache label/label_stream
    label/record label/label_stream
    describe/load_descriptor describe/features
    session/map_budget session/session
    topology/map_budget session/session
    zones/zone_file zones/zones
    areas/floor_cells areas/area_plan
    report/page_images report/page_contents
    report/world_page report/page_contents
    sources/open_source sources/frame_source
    live/open_source sources/frame_source
    sources/replay_source sources/frame_source
    live/replay_source sources/frame_source)
while(ESTANCIA_MERGED)
  list(POP_FRONT ESTANCIA_MERGED old now)
  file(CONFIGURE OUTPUT ${forwarding}/estancia/${old}.hpp
       CONTENT "#pragma once\n#pragma message(\"estancia/${old}.hpp is now estancia/${now}.hpp\")\n#include <estancia/${now}.hpp>\n")
endwhile()
install(DIRECTORY ${forwarding}/estancia DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
