// SPDX-License-Identifier: Apache-2.0
// The extension estancia._estancia: what the typed modules of the package call. Private.
#include "call.hpp"
#include "estancia/version.hpp"
#include "values.hpp"

PYBIND11_MODULE(_estancia, m) {
  using namespace estancia::python;
  translateErrors();
  m.attr("__version__") = estancia::version();
  bindSequences(m);
  bindLabelers(m);
  bindLabels(m);
  bindMapping(m);
  bindDrives(m);
  bindMaps(m);
  bindZones(m);
  bindClassifiers(m);
  bindClouds(m);
  bindRecognition(m);
  bindObjects(m);
  bindOdometry(m);
  bindStatistics(m);
  bindWords(m);
  bindLive(m);
  bindOptions(m);
}
