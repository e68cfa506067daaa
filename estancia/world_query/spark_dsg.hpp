// Spark-DSG export: a world as a 3-D scene graph for Spark-DSG (Hydra's scene graphs) and its viewers.
// Private. SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "estancia/world_file/world_map.hpp"

namespace estancia {

/// The JSON of Spark-DSG's encoding 1.0.3, which 1.0.3 to 1.1 read (`spark_dsg.DynamicSceneGraph.load`):
/// layers objects (2, ids O…), places (3, p…), rooms (4, R…) and one building (5, B0); edges between places
/// that are linked (weight: meters), areas whose places are, objects that stand on each other, and each thing
/// and the one that holds it (LayerTree). semantic_label is the best word's number in the vocabulary, and
/// that is in metadata. Throws Error (insufficientData) where a place has no position.
nlohmann::ordered_json sparkDsgJson(const WorldMap& world);

}  // namespace estancia
