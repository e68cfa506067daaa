// The whole job (decode, prepare, infer, map, write the file) beside the network's forward pass alone, in
// turn in one run.
//   bench_whole_job SEQ [MODEL [FRAMES [ROUNDS]]]
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <vector>

#include "estancia/files/image_writer.hpp"
#include "estancia/label/label_stream.hpp"
#include "estancia/labelers/model.hpp"
#include "estancia/readers/open_sequence.hpp"
#include "estancia/session/session.hpp"

namespace {

using namespace estancia;
using Clock = std::chrono::steady_clock;

double seconds(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double forwardAlone(Labeler& labeler, const std::vector<Prepared>& prepared) {
  const auto start = Clock::now();
  for (const Prepared& image : prepared) labeler.infer(image);
  return static_cast<double>(prepared.size()) / seconds(start);
}

double wholeJob(const Sequence& sequence, Labeler& labeler, std::size_t frames,
                const std::filesystem::path& file) {
  std::filesystem::remove(file);
  const auto start = Clock::now();
  auto session = MappingSession::create(file, labeler.vocabulary(), labeler.identity(), {});
  LabelStream stream(sequence, labeler);
  for (std::size_t i = 0; i < frames; ++i) {
    const auto frame = stream.next();
    const auto encoded = [&] {
      return encodeImage(frame->image.empty() ? sequence.image(frame->index) : frame->image);
    };
    session.add(sequence.frame(frame->index), frame->descriptor, encoded);
  }
  session.finish();
  return static_cast<double>(frames) / seconds(start);
}

void run(int argc, char** argv) {
  const auto sequence = openSequence(argv[1]);
  const auto labeler = loadModel(argc > 2 ? argv[2] : defaultModel);
  const std::size_t wanted = argc > 3 ? std::strtoul(argv[3], nullptr, 10) : 60;
  const std::size_t frames = std::min(sequence->size(), wanted);
  const int rounds = argc > 4 ? std::atoi(argv[4]) : 7;
  std::vector<Prepared> prepared;
  for (std::size_t i = 0; i < frames; ++i) prepared.push_back(labeler->prepare(sequence->image(i)));
  const auto file = std::filesystem::temp_directory_path() / "bench_whole_job.estancia";
  forwardAlone(*labeler, prepared);  // warm up
  std::vector<double> ratios;
  for (int round = 0; round < rounds; ++round) {
    const double forward = forwardAlone(*labeler, prepared);
    const double job = wholeJob(*sequence, *labeler, frames, file);
    ratios.push_back(job / forward);
    fmt::print("forward alone {:6.1f} frames/s, whole job {:6.1f} frames/s, ratio {:.3f}\n", forward, job,
               ratios.back());
    std::fflush(stdout);
  }
  std::filesystem::remove(file);
  std::sort(ratios.begin(), ratios.end());
  fmt::print("{} frames of {}: median ratio {:.3f}\n", frames, sequence->name(), ratios[ratios.size() / 2]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fputs("usage: bench_whole_job SEQ [MODEL [FRAMES [ROUNDS]]]\n", stderr);
    return 2;
  }
  try {
    run(argc, argv);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return 2;
  }
}
