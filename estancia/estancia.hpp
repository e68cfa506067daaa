// Estancia: the whole public API in one include. What stands here is installed; everything else is private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "estancia/core/camera.hpp"
#include "estancia/core/descriptor.hpp"
#include "estancia/core/error.hpp"
#include "estancia/core/frame.hpp"
#include "estancia/core/options.hpp"
#include "estancia/core/point_cloud.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/core/progress.hpp"
#include "estancia/core/room_predictions.hpp"
#include "estancia/core/vocabulary.hpp"

#include "estancia/stats/dendrogram.hpp"

#include "estancia/words/installed_words.hpp"
#include "estancia/words/label_choice.hpp"

#include "estancia/files/cloud_file.hpp"
#include "estancia/files/image_file.hpp"

#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "estancia/sequences/trajectory.hpp"

#include "estancia/readers/object_views.hpp"
#include "estancia/readers/open_sequence.hpp"

#include "estancia/labelers/labeler.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/labelers/model_spec.hpp"

#include "estancia/label/label_stream.hpp"

#include "estancia/describe/descriptor.hpp"
#include "estancia/describe/features.hpp"

#include "estancia/cloud/crop_object.hpp"
#include "estancia/cloud/filter.hpp"
#include "estancia/cloud/growing_neural_gas.hpp"

#include "estancia/segmentation/clusters.hpp"

#include "estancia/odometry/rgbd.hpp"

#include "estancia/check/check.hpp"

#include "estancia/map_file/map.hpp"

#include "estancia/mapper/mapper.hpp"

#include "estancia/localization/localizer.hpp"

#include "estancia/session/session.hpp"

#include "estancia/query/ask.hpp"
#include "estancia/query/drives.hpp"
#include "estancia/query/explain.hpp"
#include "estancia/query/export.hpp"
#include "estancia/query/route.hpp"

#include "estancia/zones/zone_stream.hpp"
#include "estancia/zones/zones.hpp"

#include "estancia/classify/classifier.hpp"
#include "estancia/classify/room_classifier.hpp"

#include "estancia/recognition/recognition_options.hpp"
#include "estancia/recognition/recognizer.hpp"

#include "estancia/objects/collect.hpp"
#include "estancia/objects/object_model.hpp"
#include "estancia/objects/predict.hpp"
#include "estancia/objects/training.hpp"

#include "estancia/areas/area_plan.hpp"

#include "estancia/world_file/edit_map.hpp"
#include "estancia/world_file/world_map.hpp"

#include "estancia/world/map_sequence.hpp"
#include "estancia/world/world_mapper.hpp"

#include "estancia/world_query/ask_world.hpp"
#include "estancia/world_query/changes.hpp"
#include "estancia/world_query/export_world.hpp"
#include "estancia/world_query/route_world.hpp"

#include "estancia/joining/merge_maps.hpp"

#include "estancia/figures/floor_plan.hpp"

#include "estancia/report/map_page.hpp"
#include "estancia/report/page_contents.hpp"
#include "estancia/report/zones_page.hpp"

#include "estancia/sources/frame_source.hpp"

#include "estancia/live/live_loop.hpp"
#include "estancia/live/live_view.hpp"

#include "estancia/fwd.hpp"
#include "estancia/version.hpp"
