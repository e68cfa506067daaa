// A model looked for in a scene, from matching to verification: thesis 2.4.4 to 2.4.7.
#pragma once

#include <vector>

#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/recognizer.hpp"

namespace estancia {

/// The instances of a model, best first. `described` and `there` are the two for the lengths of the search;
/// `account` is told what each stage kept.
std::vector<Detection> detectionsOf(const RecognitionOptions& options, const PreparedModel& model,
                                    const PreparedModel::Described& described, const PreparedScene& scene,
                                    const PreparedScene::Described& there, StageAccount& account);

}  // namespace estancia
