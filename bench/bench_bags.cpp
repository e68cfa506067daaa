// Bags: opening and reading, beside reading the same files plainly.
//   bench_bags FOLDER [options of Google Benchmark]
//                           writes bags of 600 made-up images of 640 × 480 pixels (0.5 GB each) into FOLDER
//   bench_bags BAG… [options of Google Benchmark]
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "estancia/ros/bag.hpp"
#include "ros/bag_writer.hpp"

namespace {

using namespace estancia;
namespace fs = std::filesystem;

/// A camera, odometry and transforms. Half of each image is noise, half of it is plain.
std::vector<test::WrittenMessage> drive() {
  constexpr std::size_t imageBytes = 640 * 480 * 3;
  std::mt19937 random(7);
  std::string image(imageBytes + 60, '\0');
  for (std::size_t i = 0; i < imageBytes; ++i)
    image[60 + i] = static_cast<char>(i / 30720 + (i / 1920 % 2 == 0 ? random() % 8 : 0));
  std::vector<test::WrittenMessage> messages;
  for (std::int64_t i = 0; i < 600; ++i) {
    const std::int64_t time = 1'700'000'000'000'000'000 + i * 33'000'000;
    messages.push_back({"/camera/image_raw", "sensor_msgs/msg/Image", time, image});
    for (int k = 0; k < 3; ++k)
      messages.push_back({"/odom", "nav_msgs/msg/Odometry", time + 1 + k, std::string(720, 'o')});
    messages.push_back({"/tf", "tf2_msgs/msg/TFMessage", time + 9, std::string(110, 't')});
  }
  return messages;
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::vector<fs::path> writeBags(const fs::path& folder) {
  const auto messages = drive();
  std::vector<fs::path> bags;
  for (const char* compression : {"none", "lz4"}) {
    bags.push_back(folder / (std::string("ros1_") + compression + ".bag"));
    write(bags.back(), test::ros1Bag(messages, {.compression = compression}));
  }
  for (const char* compression : {"none", "lz4", "zstd"}) {
    bags.push_back(folder / (std::string("chunks_") + compression + ".mcap"));
    write(bags.back(), test::mcapBag(messages, {.compression = compression}));
  }
  bags.push_back(folder / "no_chunks.mcap");
  write(bags.back(), test::mcapBag(messages, {.chunkBytes = 0, .index = false}));
  bags.push_back(folder / "sqlite.db3");
  fs::remove(bags.back());
  test::writeSqliteBag(bags.back(), messages);
  return bags;
}

void setSpeed(benchmark::State& state, std::uint64_t bytes) {
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes * state.iterations()));
}

void openAgain(benchmark::State& state, const fs::path& path) {
  std::size_t messages = 0;
  for (auto _ : state) messages = ros::openBag(path)->messages().size();
  state.counters["messages"] = static_cast<double>(messages);
}

/// All messages in order, by the bytes of their payloads.
void readAll(benchmark::State& state, const fs::path& path) {
  std::uint64_t bytes = 0;
  for (auto _ : state) {
    const auto bag = ros::openBag(path);
    bytes = 0;
    for (std::size_t i = 0; i < bag->messages().size(); ++i) {
      const ros::Payload payload = bag->read(i);
      bytes += payload.bytes.size();
      benchmark::DoNotOptimize(payload.bytes.data());
    }
  }
  setSpeed(state, bytes);
}

/// The floor: the file into one buffer, again and again.
void readPlainly(benchmark::State& state, const fs::path& path) {
  std::vector<char> buffer(1 << 20);
  std::uint64_t bytes = 0;
  for (auto _ : state) {
    const int file = ::open(path.c_str(), O_RDONLY);
    bytes = 0;
    for (ssize_t count = 1; count > 0; bytes += static_cast<std::uint64_t>(count))
      count = pread(file, buffer.data(), buffer.size(), static_cast<off_t>(bytes));
    close(file);
  }
  setSpeed(state, bytes);
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<fs::path> bags;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) bags.emplace_back(argv[i]);
  if (bags.empty()) return std::fputs("usage: bench_bags FOLDER|BAG… [--benchmark_…]\n", stderr), 2;
  if (bags.size() == 1 && fs::is_directory(bags.front())) bags = writeBags(bags.front());
  for (const fs::path& bag : bags) {
    const std::string name = bag.filename().string();
    constexpr auto unit = benchmark::kMillisecond;
    benchmark::RegisterBenchmark((name + " plain").c_str(), readPlainly, bag)->Unit(unit);
    benchmark::RegisterBenchmark((name + " open").c_str(), openAgain, bag)->Unit(unit);
    benchmark::RegisterBenchmark((name + " read").c_str(), readAll, bag)->Unit(unit);
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
} catch (const std::exception& e) {
  return std::fprintf(stderr, "%s\n", e.what()), 2;
}
