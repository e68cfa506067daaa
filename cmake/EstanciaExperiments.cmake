# SPDX-License-Identifier: Apache-2.0
# The experiments: a library of the command and of the tests alone, which is not installed.
file(GLOB_RECURSE experiment_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/experiments/src/*.cpp)
list(FILTER experiment_sources EXCLUDE REGEX "_module\\.cpp$")
add_library(estancia_experiments STATIC ${experiment_sources})
estancia_defaults(estancia_experiments LIGHT)
target_link_libraries(estancia_experiments PUBLIC estancia
                      PRIVATE opencv_core opencv_imgproc opencv_features2d fmt::fmt tomlplusplus::tomlplusplus Threads::Threads
                              $<BUILD_INTERFACE:Boost::boost> nlohmann_json::nlohmann_json)
estancia_use_mpi(estancia_experiments experiments/src/runner/mpi_processes)
set(thesis experiments/thesis)
estancia_embed(
  estancia_experiments experiments/src/findings/thesis.hpp estancia::experiments
  thesisRecognitionCsv:${thesis}/recognition.csv thesisRecognitionMeansCsv:${thesis}/recognition-means.csv
  thesisScenesCsv:${thesis}/scenes.csv thesisZonesCountsCsv:${thesis}/zones-counts.csv
  thesisZonesWithinCsv:${thesis}/zones-within.csv thesisObjectsCsv:${thesis}/objects.csv)
