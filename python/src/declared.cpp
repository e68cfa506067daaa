// SPDX-License-Identifier: Apache-2.0
// Declared options: what keyword arguments the package's functions take.
#include "estancia/check/check.hpp"
#include "estancia/classify/classifier.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/localization/localizer.hpp"
#include "estancia/mapper/mapper.hpp"
#include "estancia/objects/collect.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/training.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/query/export.hpp"
#include "estancia/query/route.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/recognition/recognition_options.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/session/session.hpp"
#include "estancia/sources/replay_source.hpp"
#include "estancia/stats/method_comparison.hpp"
#include "estancia/world/world_mapper.hpp"
#include "estancia/world_file/world_options.hpp"
#include "estancia/zones/zone_stream.hpp"
#include "estancia/zones/zones.hpp"
#include "options.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

template <class Options>
void add(py::dict& all, const char* name) {
  Options options;
  all[name] = describeOptions(declare(options));
}

py::dict allOptions() {
  py::dict all;
  add<SequenceOptions>(all, "SequenceOptions");
  add<CheckOptions>(all, "CheckOptions");
  add<LabelerOptions>(all, "LabelerOptions");
  add<LabelStreamOptions>(all, "LabelStreamOptions");
  add<DescriptorFileOptions>(all, "LabelFileOptions");
  add<MapperOptions>(all, "MapperOptions");
  add<MapBudget>(all, "MapBudget");
  add<WorldOptions>(all, "WorldOptions");
  add<LocalizerOptions>(all, "LocalizerOptions");
  add<RouteOptions>(all, "RouteOptions");
  add<ExportOptions>(all, "ExportOptions");
  add<ZoneOptions>(all, "ZoneOptions");
  add<ZoneStreamOptions>(all, "ZoneStreamOptions");
  add<ClassifierOptions>(all, "ClassifierOptions");
  add<CloudFileOptions>(all, "CloudFileOptions");
  add<FilterOptions>(all, "FilterOptions");
  add<GngOptions>(all, "GngOptions");
  add<NormalOptions>(all, "NormalOptions");
  add<ClusterOptions>(all, "ClusterOptions");
  add<RecognitionOptions>(all, "RecognitionOptions");
  add<CollectOptions>(all, "CollectOptions");
  add<TrainingOptions>(all, "TrainingOptions");
  add<PredictOptions>(all, "PredictOptions");
  add<RgbdOptions>(all, "RgbdOptions");
  add<ReplayOptions>(all, "ReplayOptions");
  add<ComparisonOptions>(all, "ComparisonOptions");
  return all;
}

}  // namespace

void bindOptions(py::module_& m) {
  m.def("options", allOptions);
}

}  // namespace estancia::python
