// Poses that groups of matches agree on, refined and verified as in thesis 2.4.6 and 2.4.7.
#pragma once

#include <vector>

#include "estancia/recognition/prepared.hpp"
#include "estancia/recognition/verify.hpp"

namespace estancia {

/// A pose and what the scene says of it.
struct CandidatePose {
  cv::Affine3d pose;  ///< T_scene_model
  Evidence evidence;
};

/// Refines poses with few points of the model, the best of these with many; most inliers first, different
/// ones.
std::vector<CandidatePose> candidatesOf(const std::vector<TriedPose>& poses,
                                        const PreparedModel::Described& model,
                                        const PreparedScene::Described& scene,
                                        const RecognitionOptions& options);

/// Drops those that the verification asked for, global or by inliers, does not confirm.
void keepVerified(std::vector<CandidatePose>& candidates, const PreparedModel::Described& model,
                  const PreparedScene::Described& scene, const RecognitionOptions& options);

}  // namespace estancia
