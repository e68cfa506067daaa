// Estancia: the whole public API in one include. What stands here is installed; everything else is private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/camera.hpp"
#include "estancia/core/choice.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/label_probability.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"

#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/distance.hpp"
#include "estancia/stats/linkage.hpp"

#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_search.hpp"
#include "estancia/words/label_senses.hpp"
#include "estancia/words/lexicon.hpp"
#include "estancia/words/room_words.hpp"
#include "estancia/words/word_associations.hpp"
#include "estancia/words/word_graph.hpp"
#include "estancia/words/wordnet.hpp"

#include "estancia/io/cloud_file.hpp"
#include "estancia/io/descriptor_sequence.hpp"
#include "estancia/io/home_plan.hpp"
#include "estancia/io/image_file.hpp"
#include "estancia/io/object_views.hpp"
#include "estancia/io/sequence.hpp"
#include "estancia/io/trajectory.hpp"

#include "estancia/label/label_cache.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/label/labeler.hpp"
#include "estancia/label/model.hpp"
#include "estancia/label/model_spec.hpp"
#include "estancia/label/record.hpp"

#include "estancia/describe/descriptor.hpp"
#include "estancia/describe/features.hpp"
#include "estancia/describe/load_descriptor.hpp"

#include "estancia/cloud/clusters.hpp"
#include "estancia/cloud/crop_object.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/cloud/growing_neural_gas.hpp"
#include "estancia/cloud/noise.hpp"
#include "estancia/cloud/normals.hpp"
#include "estancia/cloud/resolution.hpp"

#include "estancia/odometry/rgbd.hpp"
#include "estancia/odometry/tracker.hpp"

#include "estancia/check/check.hpp"

#include "estancia/topology/ask.hpp"
#include "estancia/topology/explain.hpp"
#include "estancia/topology/export.hpp"
#include "estancia/topology/localizer.hpp"
#include "estancia/topology/map.hpp"
#include "estancia/topology/mapper.hpp"
#include "estancia/topology/quality.hpp"
#include "estancia/topology/route.hpp"
#include "estancia/topology/session.hpp"

#include "estancia/zones/zone_file.hpp"
#include "estancia/zones/zone_stream.hpp"
#include "estancia/zones/zones.hpp"

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/room_classifier.hpp"
#include "estancia/classify/scores.hpp"
#include "estancia/classify/zero_shot_rooms.hpp"

#include "estancia/recognition/recognition_options.hpp"
#include "estancia/recognition/recognizer.hpp"

#include "estancia/objects/collect.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/training.hpp"

#include "estancia/report/cloud_image.hpp"
#include "estancia/report/floor_plan.hpp"
#include "estancia/report/map_page.hpp"
#include "estancia/report/measures.hpp"
#include "estancia/report/page_images.hpp"
#include "estancia/report/world_page.hpp"
#include "estancia/report/zones_page.hpp"

#include "estancia/fwd.hpp"
#include "estancia/version.hpp"
