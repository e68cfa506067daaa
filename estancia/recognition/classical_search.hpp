// Classical pose search: ICP refinement and verification of grouped matches (thesis 2.4.6 and 2.4.7).
#pragma once

#include <vector>

#include "estancia/recognition/pose_hypothesis.hpp"
#include "estancia/recognition/prepared.hpp"

namespace estancia {

/// Refines poses with the coarse points of the model, and the best of these with the fine ones. Most inliers
/// first, distinct ones.
std::vector<PoseHypothesis> refineClassical(std::vector<PoseHypothesis> poses,
                                            const PreparedModel::Described& model,
                                            const PreparedScene::Described& scene,
                                            const RecognitionOptions& options);

/// The poses that the verification of `options`, "global" or "inliers", accepts.
std::vector<PoseHypothesis> verifyClassical(const std::vector<PoseHypothesis>& poses,
                                            const PreparedModel::Described& model,
                                            const PreparedScene::Described& scene,
                                            const RecognitionOptions& options);

}  // namespace estancia
