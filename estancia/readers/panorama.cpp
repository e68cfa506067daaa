// Panorama tour: perspective views of equirectangular panoramas.
//
// Every panorama is a place. Its center column has heading 0 (the map's x axis), headings grow to the left
// (counter-clockwise), as everywhere in the map. Headings are true, positions are INVENTED, since panoramas
// have none: places lie on a circle around the origin, 4 m apart.
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "estancia/core/digest.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/readers/formats.hpp"

namespace estancia::io {
namespace fs = std::filesystem;
namespace {

constexpr double halfTurn = std::numbers::pi;
constexpr double spacing = 4;       // between neighboring places [m]
const cv::Size viewSize(320, 240);  // a 512-pixel panorama holds no more detail than this

const std::vector<std::string>& panoramaSuffixes() {
  static const std::vector<std::string> suffixes = {".exr", ".hdr", ".exr.js", ".hdr.js"};
  return suffixes;
}

/// "lab.exr.js" → "lab"
std::string placeName(const fs::path& file) {
  return printable((file.extension() == ".js" ? file.stem() : file).stem().string());
}

/// A level pinhole camera: the panorama coordinates of each of its pixels, in fractions of width and height.
class Camera {
 public:
  explicit Camera(double fieldOfView)
      : focal_(viewSize.width / 2.0 / std::tan(fieldOfView / 360 * halfTurn)),
        right_(viewSize, CV_32F),
        down_(viewSize, CV_32F) {
    for (int v = 0; v < viewSize.height; ++v) {
      for (int u = 0; u < viewSize.width; ++u) {
        const double x = (u + 0.5 - viewSize.width / 2.0) / focal_;
        const double y = (v + 0.5 - viewSize.height / 2.0) / focal_;
        right_.at<float>(v, u) = static_cast<float>(std::atan(x) / (2 * halfTurn));
        down_.at<float>(v, u) = static_cast<float>(0.5 + std::atan(y / std::hypot(x, 1.0)) / halfTurn);
      }
    }
  }

  /// Width of a panorama with the resolution of the views [pixels].
  int usefulWidth() const { return static_cast<int>(2 * halfTurn * focal_); }

  /// The view along `heading` [degrees in [0, 360), counter-clockwise].
  cv::Mat look(const cv::Mat& panorama, double heading) const {
    const double ahead = heading <= 180 ? 0.5 - heading / 360 : 1.5 - heading / 360;  // fraction of the width
    cv::Mat columns, rows, view;
    right_.convertTo(columns, CV_32F, panorama.cols, ahead * panorama.cols - 0.5);
    down_.convertTo(rows, CV_32F, panorama.rows, -0.5);
    cv::remap(panorama, view, columns, rows, cv::INTER_CUBIC, cv::BORDER_WRAP);
    return view;
  }

 private:
  double focal_;  // [pixels]
  cv::Mat right_, down_;
};

/// Views cut out of equirectangular panoramas. Invariant: one view a frame, in their order. Files are tone
/// mapped on request; `mutex_` guards their digests and the few that are kept in memory.
class PanoramaTour final : public ListedSequence {
 public:
  PanoramaTour(const fs::path& folder, const SequenceOptions& options)
      : ListedSequence(nameOf(folder)),
        exposure_(options.exposure),
        fieldOfView_(options.fieldOfView),
        camera_(options.fieldOfView) {
    files_ = filesIn(folder, panoramaSuffixes());
    if (files_.empty()) files_ = filesIn(folder, imageSuffixes());
    if (files_.empty())
      fail(ErrorCode::insufficientData, "{}: no panoramas in this folder (.exr, .hdr, .exr.js, .jpg, .png …)",
           printable(folder));

    const std::size_t places = files_.size();
    const double radius = places > 1 ? spacing / 2 / std::sin(halfTurn / static_cast<double>(places)) : 0;
    const double step = 360.0 / options.views;
    for (int round = 0; round < options.rounds; ++round) {
      // Later rounds look between the headings of the earlier ones; steps of the golden ratio never repeat.
      const double between = step * std::fmod(round * (std::numbers::phi - 1), 1.0);
      for (std::size_t place = 0; place < places; ++place) {
        const double direction = 2 * halfTurn * static_cast<double>(place) / static_cast<double>(places);
        for (int k = 0; k < options.views; ++k) {
          double heading = std::fmod(step * k + between + options.turn, 360.0);
          if (heading < 0) heading += 360;
          const std::string room = placeName(files_[place]);
          entries_.push_back({fmt::format("{}/r{}_h{:03}", room, round + 1, std::lround(heading) % 360),
                              static_cast<double>(entries_.size()),
                              Pose::planar(radius * std::cos(direction), radius * std::sin(direction),
                                           heading / 180 * halfTurn),
                              room});
          views_.push_back({place, heading});
        }
      }
    }
  }

  cv::Mat image(std::size_t i) const override {
    return camera_.look(toneMapped(views_.at(i).place), views_[i].heading);
  }

  std::string fingerprint(std::size_t i) const override {
    const View& view = views_.at(i);
    std::string digest;
    {
      const std::lock_guard lock(mutex_);
      digests_.resize(files_.size());
      std::string& known = digests_[view.place];
      if (known.empty()) known = sha256OfFile(files_[view.place]);
      digest = known;
    }
    return fmt::format("{} view {} {} {} {}x{}", digest, view.heading, exposure_, fieldOfView_,
                       viewSize.width, viewSize.height);
  }

 private:
  struct View {
    std::size_t place;
    double heading;  // [degrees]
  };
  struct ToneMapped {
    std::size_t place;
    cv::Mat image;
  };

  cv::Mat toneMapped(std::size_t place) const {
    {
      const std::lock_guard lock(mutex_);
      for (const ToneMapped& d : recent_)
        if (d.place == place) return d.image;
    }
    // Outside the lock: other threads may render their places meanwhile.
    cv::Mat panorama = readPanorama(files_[place]);
    const int width = camera_.usefulWidth();
    if (panorama.cols > width)
      cv::resize(panorama, panorama, {width, std::max(1, width / 2)}, 0, 0, cv::INTER_AREA);
    cv::Mat image = toneMap(panorama, exposure_);
    const std::lock_guard lock(mutex_);
    recent_.push_back({place, image});
    if (recent_.size() > 4) recent_.erase(recent_.begin());
    return image;
  }

  std::vector<fs::path> files_;
  std::vector<View> views_;
  double exposure_, fieldOfView_;
  Camera camera_;
  mutable std::mutex mutex_;
  mutable std::vector<std::string> digests_;  // digests of the files, "" until requested
  mutable std::vector<ToneMapped> recent_;    // newest last; a tour visits one place after the other
};
}  // namespace

static bool isPanoramas(const fs::path& path) {
  return fs::is_directory(path) && !filesIn(path, panoramaSuffixes()).empty();
}

const SequenceFormat panoramaFormat{
    "panorama", "views of equirectangular panoramas: .exr, .hdr, .exr.js (.jpg and .png only with this type)",
    isPanoramas, openAs<PanoramaTour>};

}  // namespace estancia::io
