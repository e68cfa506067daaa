// SPDX-License-Identifier: Apache-2.0
#include "estancia/labelers/labeler.hpp"

#include "estancia/core/frame_failure.hpp"

namespace estancia {

LexicalDescriptor Labeler::adopt(std::span<const LabelProbability>) {
  throw Error(ErrorCode::invalidState, "this labeler has a fixed vocabulary and adopts no words");
}

LexicalDescriptor Labeler::combine(std::span<const LexicalDescriptor>) const {
  throw Error(ErrorCode::invalidState, "this labeler has no members to combine");
}

std::vector<LexicalDescriptor> Labeler::labelRegions(const cv::Mat&, std::span<const cv::Rect2d>) {
  throw Error(ErrorCode::invalidInput, "this labeler is no detector: it says nothing of regions of an image");
}

std::vector<LabelResult> Labeler::inferBatch(std::span<const Prepared> batch) {
  std::vector<LabelResult> results;
  for (const Prepared& prepared : batch) try {
      results.push_back({infer(prepared), ""});
    } catch (const FrameError& e) {
      results.push_back({{}, e.what()});
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& e) {
      results.resize(batch.size());
      throw BatchError(e, std::move(results));
    } catch (...) {
      results.push_back({{}, frameFailure(prepared.frame).what()});
    }
  return results;
}

}  // namespace estancia
