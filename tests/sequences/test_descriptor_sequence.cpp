// Descriptor files: read in the formats of other tools, written for other tools.
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <bit>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include "estancia/core/error.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/sequence.hpp"
#include "support/errors.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::readFile;
using test::writeFile;
using testing::ElementsAre;

std::vector<std::string> namesOf(const DescriptorSequence& sequence) {
  std::vector<std::string> names;
  for (const Frame& frame : sequence.frames) names.push_back(frame.name);
  return names;
}

/// A .npy file of version 1 with any header and any bytes behind it.
std::string npy(const std::string& header, const std::string& data) {
  std::string bytes = std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size() & 0xFFU) +
                      static_cast<char>(header.size() >> 8U);
  return bytes + header + data;
}

std::string headerOf(const std::string& type, const std::string& shape,
                     const std::string& fortran = "False") {
  return "{'descr': " + type + ", 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

template <class Number>
std::string bytesOf(const std::vector<Number>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)};
}

class DescriptorFiles : public testing::Test {
 protected:
  DescriptorSequence read(const std::string& name, const std::string& bytes,
                          const DescriptorFileOptions& options = {}) {
    return readDescriptors(file(name, bytes), options);
  }
  test::Caught refusal(const std::string& name, const std::string& bytes,
                       const DescriptorFileOptions& options = {}) {
    return test::caught([&] { read(name, bytes, options); });
  }
  fs::path file(const std::string& name, const std::string& bytes) {
    writeFile(scratch_ / name, bytes);
    return scratch_ / name;
  }
  test::ScratchFolder scratch_;
};

TEST_F(DescriptorFiles, WideCsv) {
  const auto sequence = read("a.csv",
                             "\xEF\xBB\xBFimage, cup ,\"mug, beaker\",crane,crane\r\n1.png,0.5,0.25,0,1\n"
                             "\"2,b.png\",1e-5,1.00005,-0.00001,.5\n");
  EXPECT_THAT(sequence.vocabulary.labels(), ElementsAre("cup", "mug, beaker", "crane", "crane"));
  EXPECT_THAT(namesOf(sequence), ElementsAre("1.png", "2,b.png"));
  EXPECT_THAT(sequence.descriptors.row(0), ElementsAre(0.5F, 0.25F, 0, 1));
  EXPECT_THAT(sequence.descriptors.row(1), ElementsAre(1e-5F, 1, 0, 0.5F)) << "rounding is clamped";
  EXPECT_THAT(sequence.model, testing::StartsWith("recorded "));
}

TEST_F(DescriptorFiles, LongCsv) {
  const std::string text = "image,label,probability\n1.png,cup,0.5\n2.png,mug,0.25\n1.png,spoon,0.75\n";
  const auto sequence = read("a.csv", text);
  EXPECT_THAT(sequence.vocabulary.labels(), ElementsAre("spoon", "cup", "mug"));
  EXPECT_THAT(namesOf(sequence), ElementsAre("1.png", "2.png"));
  EXPECT_THAT(sequence.descriptors.row(0), ElementsAre(0.75F, 0.5F, 0));
  const auto given = read("a.csv", text, {file("words.txt", "mug\nfork\ncup\n"), {}});
  EXPECT_THAT(given.descriptors.row(0), ElementsAre(0, 0, 0.5F));
  EXPECT_THAT(given.descriptors.row(1), ElementsAre(0.25F, 0, 0));
  EXPECT_NE(given.model, sequence.model) << "other words";
}

TEST_F(DescriptorFiles, JsonLines) {
  const auto sequence = read("a.jsonl", R"({"image": "1.png", "labels": {"cup": 0.25, "mug": 0.75}}

{"image": "2.png", "error": "too dark"}
{"image": "3.png", "labels": [{"label": "spoon", "confidence": 1}], "time": 3})");
  EXPECT_THAT(namesOf(sequence), ElementsAre("1.png", "3.png"));
  EXPECT_THAT(sequence.vocabulary.labels(), ElementsAre("mug", "cup", "spoon"));
  EXPECT_THAT(sequence.descriptors.row(0), ElementsAre(0.75F, 0.25F, 0));
  EXPECT_THAT(sequence.descriptors.row(1), ElementsAre(0, 0, 1));
}

TEST_F(DescriptorFiles, Npy) {
  file("a.labels.txt", "cup\nmug\n");
  const auto floats = read("a.npy", npy(headerOf("'<f4'", "(2, 2)"), bytesOf<float>({0, 0.25F, 0.5F, 1})));
  EXPECT_THAT(namesOf(floats), ElementsAre("frame 000000", "frame 000001"));
  EXPECT_THAT(floats.descriptors.row(1), ElementsAre(0.5F, 1));
  const auto doubles = read("a.npy", npy(headerOf("'<f8'", "(1, 2)"), bytesOf<double>({0.1, 1.00001})),
                            {{}, file("names.txt", "room/1.png\n")});
  EXPECT_THAT(doubles.descriptors.row(0), ElementsAre(0.1F, 1));
  EXPECT_THAT(namesOf(doubles), ElementsAre("room/1.png"));
  const auto listed = read("a.npy", npy(headerOf("'<f4'", "(1, 2)"), bytesOf<float>({0, 1})),
                           {{}, file("list.csv", "index,room,image,timestamp\n0,\"a, b\",x.png,1.5\n")});
  EXPECT_THAT(listed.frames[0], testing::FieldsAre("x.png", 1.5, testing::Eq(std::nullopt), "a, b"));
}

TEST_F(DescriptorFiles, SurviveTheRoundTrip) {
  std::mt19937 random(1);
  DescriptorSequence sequence{
      Vocabulary({"cup, mug", "\"quoted\"", "crane", "crane", "größe"}), "m", {}, DescriptorMatrix(5)};
  for (int i = 0; i < 500; ++i) {
    LexicalDescriptor row;
    for (int k = 0; k < 5; ++k)  // any float in [0, 1], tiny ones too
      row.push_back(
          std::bit_cast<float>(std::uniform_int_distribution<std::uint32_t>(0, 0x3F800000)(random)));
    sequence.descriptors.append(row);
    Frame frame;
    frame.name = "room, \"1\"/" + std::to_string(i) + ".png";
    if (i % 2 == 0) frame.timestamp = 1e9 + 0.1 * i;
    if (i % 3 == 0) frame.pose = Pose::planar(0.1 * i, -2, 0.3);
    if (i % 5 == 0) frame.room = "kitchen, small";
    sequence.frames.push_back(frame);
  }
  writeDescriptors(sequence, scratch_ / "r.csv");
  writeDescriptors(sequence, scratch_ / "r.npy");
  for (const std::string name : {"r.csv", "r.npy"}) {
    const auto back = readDescriptors(scratch_ / name);
    EXPECT_EQ(back.vocabulary, sequence.vocabulary);
    EXPECT_EQ(namesOf(back), namesOf(sequence));
    EXPECT_EQ(back.descriptors.values(), sequence.descriptors.values()) << name;
  }
  const auto frames = readDescriptors(scratch_ / "r.npy").frames;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].timestamp, sequence.frames[i].timestamp);
    EXPECT_EQ(frames[i].room, sequence.frames[i].room);
    EXPECT_EQ(frames[i].pose.value_or(Pose{}).qz, sequence.frames[i].pose.value_or(Pose{}).qz);
  }
  const std::string bytes = readFile(scratch_ / "r.npy");
  EXPECT_EQ((bytes.size() - 500 * 5 * 4) % 64, 0U) << "NumPy aligns the numbers";
}

TEST_F(DescriptorFiles, RefuseBadCsv) {
  for (const char* text :
       {"", "1.png,0.5\n", "image,cup,\n1,0,0\n", "image,cup\n1.png,nan\n", "image,cup\n1.png,87\n",
        "image,cup\n1.png,high\n", "image,cup,mug\n1.png,0,1\n2.png,0\n", "image,cup\n1.png,0\n1.png,1\n",
        "image,cup\n,0\n", "image,cup\n\"1.png,0\n", "image,label,probability\n1.png,cup\n",
        "image,label,probability\n1.png,cup,NaN\n", "image,label,probability\n1.png, ,1\n"})
    EXPECT_THAT(refusal("a.csv", text), FailsWith(ErrorCode::malformedFile)) << text;
  for (const char* text : {"image,cup\n", "image,label,probability\n"})
    EXPECT_THAT(refusal("a.csv", text), FailsWith(ErrorCode::insufficientData)) << text;
  EXPECT_THAT(refusal("a.csv", "image,cup\n1.png,0\n", {file("words.txt", "mug\n"), {}}),
              FailsWith(ErrorCode::mismatch));
  EXPECT_THAT(refusal("a.txt", "image,cup\n"), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { readDescriptors(scratch_ / "none.csv"); }, FailsWith(ErrorCode::fileNotFound));
}

TEST_F(DescriptorFiles, RefuseBadJsonLines) {
  const std::string empty = R"({"image": "1", "labels": {}})";
  for (const std::string& text :
       {empty + "\n{\"image\"", std::string(R"({"labels": {"cup": 1}})"),
        std::string(R"({"image": "1", "labels": {"cup": 2}})"), empty + "\n" + empty, std::string(500, 'x'),
        std::string(R"({"image": "1", "labels": {"cup": NaN}})"),
        std::string(R"({"image": "1", "labels": 7})"), std::string(R"({"image": "1"})"),
        std::string(R"({"image": 7, "labels": {"cup": 1}})"),
        std::string(R"({"image": "1", "labels": {"cup": "much"}})")})
    EXPECT_THAT(refusal("a.jsonl", text), FailsWith(ErrorCode::malformedFile)) << text;
  for (const std::string& text : {std::string(), empty})
    EXPECT_THAT(refusal("a.jsonl", text), FailsWith(ErrorCode::insufficientData)) << text;
}

/// Few bytes must not make much memory.
TEST_F(DescriptorFiles, RefuseAHugeProductOfImagesAndWords) {
  std::string text = "image,label,probability\n";
  for (int i = 0; i < 30'000; ++i) text += std::to_string(i) + "," + std::to_string(i) + ",1\n";
  EXPECT_THAT(refusal("a.csv", text), FailsWith(ErrorCode::tooLarge));
}

TEST_F(DescriptorFiles, RefuseBadNpy) {
  file("a.labels.txt", "cup\nmug\n");
  const std::string two = bytesOf<float>({0, 1}), sound = npy(headerOf("'<f4'", "(1, 2)"), two);
  for (const std::string& bytes :
       {sound.substr(0, 30), npy(headerOf("'<f4'", "(1, 2)"), two.substr(1)), sound + "x",
        npy(headerOf("'<f4'", "(2, 2)"), two), npy(headerOf("'<f4'", "(9223372036854775808, 2)"), two),
        npy(headerOf("'<f4'", "(2, 9223372036854775809)"), two)})
    EXPECT_THAT(refusal("a.npy", bytes), FailsWith(ErrorCode::truncatedFile));
  for (const char* shape : {"(99999999999999999999, 2)", "(2,)", "(1, 1, 2)", "(0, 2)", "(-1, 2)"})
    EXPECT_THAT(refusal("a.npy", npy(headerOf("'<f4'", shape), two)), FailsWith(ErrorCode::unsupportedFile))
        << shape;
  for (const char* type : {"'>f4'", "'|O'", "[('a', '<f4')]"})
    EXPECT_THAT(refusal("a.npy", npy(headerOf(type, "(1, 2)"), two)), FailsWith(ErrorCode::unsupportedFile))
        << type;
  for (const std::string& bytes : {std::string(), std::string("PK\x03\x04 an archive"), npy("{}\n", two),
                                   npy(headerOf("'<f4'", "(1, 2)", "True"), two)})
    EXPECT_THAT(refusal("a.npy", bytes), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(refusal("a.npy", npy(headerOf("'<f4'", "(2, 1)"), two)), FailsWith(ErrorCode::mismatch));
  for (const float wrong : {std::numeric_limits<float>::quiet_NaN(), 2.F})
    EXPECT_THAT(refusal("a.npy", npy(headerOf("'<f4'", "(1, 2)"), bytesOf<float>({0, wrong}))),
                FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("a.npy", sound, {{}, file("n.csv", "1.png\n2.png\n")}), FailsWith(ErrorCode::mismatch));
  for (const char* names : {"image,x\n1.png,7\n", "image,timestamp\n1.png,soon\n"})
    EXPECT_THAT(refusal("a.npy", sound, {{}, file("n.csv", names)}), FailsWith(ErrorCode::malformedFile));
  EXPECT_THAT(refusal("a.npy", std::string(sound).replace(6, 1, "\4")),
              FailsWith(ErrorCode::unsupportedFile));
  const std::string second = std::string(sound).replace(6, 1, "\2").insert(10, 2, '\0');
  EXPECT_THAT(read("a.npy", second).descriptors.row(0), ElementsAre(0, 1)) << "version 2 has a longer length";
  EXPECT_THAT(refusal("b.npy", sound), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { writeDescriptors(read("a.npy", sound), scratch_ / "r.bin"); },
              FailsWith(ErrorCode::unsupportedFile));
}

DescriptorSequence sample() {
  DescriptorSequence sequence{
      Vocabulary({"cup", "cat", "kitchen"}, {{2, 1}, {1, 0.5F}}), "net 0123", {}, DescriptorMatrix(3)};
  sequence.frames.push_back({"a.jpg", 1.25, Pose{1, 2, 3, 0, 0, 0, 1}, "kitchen"});
  sequence.frames.push_back({"b \xff.jpg", {}, {}, ""});
  sequence.descriptors.append(LexicalDescriptor{0.1F, 0.9F, 1});
  sequence.descriptors.append(LexicalDescriptor{1e-30F, 1.0F / 3, 0});
  return sequence;
}

TEST(LabelFile, KeepsEverythingExactly) {
  const test::ScratchFolder scratch;
  const fs::path file = scratch / "words.labels";
  const DescriptorSequence before = sample();
  writeDescriptors(before, file);
  const DescriptorSequence after = readDescriptors(file);
  EXPECT_EQ(after.vocabulary, before.vocabulary);
  EXPECT_EQ(after.vocabulary.layout().parts, before.vocabulary.layout().parts);
  EXPECT_EQ(after.model, before.model);
  EXPECT_EQ(after.descriptors.values(), before.descriptors.values());
  ASSERT_EQ(after.frames.size(), 2U);
  const auto place = testing::Optional(testing::FieldsAre(1, 2, 3, 0, 0, 0, 1));
  EXPECT_THAT(after.frames[0], testing::FieldsAre("a.jpg", 1.25, place, "kitchen"));
  EXPECT_THAT(after.frames[1],
              testing::FieldsAre("b \\xFF.jpg", std::nullopt, testing::Eq(std::nullopt), ""));
}

TEST(LabelFile, TextsOfOthersAreReadWithoutControlCharacters) {
  const test::ScratchFolder scratch;
  DescriptorSequence recording = sample();
  recording.vocabulary = Vocabulary({"cup\x1B[2J", "cat", "kitchen"}, {{2, 1}, {1, 0.5F}});
  recording.model = "net\x1B";
  recording.frames[0].room = "kitchen\x1B";
  writeDescriptors(recording, scratch / "words.labels");
  const DescriptorSequence after = readDescriptors(scratch / "words.labels");
  EXPECT_EQ(after.vocabulary, Vocabulary({"cup\\x1B[2J", "cat", "kitchen"}, {{2, 1}, {1, 0.5F}}));
  EXPECT_EQ(after.model, "net\\x1B");
  EXPECT_EQ(after.frames[0].room, "kitchen\\x1B");
}

TEST(LabelFile, IsRefusedWhenItIsCutAnywhereOrDamaged) {
  const test::ScratchFolder scratch;
  writeDescriptors(sample(), scratch / "whole.labels");
  const std::string whole = readFile(scratch / "whole.labels");
  constexpr std::size_t magicVersionAndDigest = 8 + 4 + 64;
  const auto reading = [&](const std::string& bytes) {
    writeFile(scratch / "a.labels", bytes);
    return test::caught([&] { readDescriptors(scratch / "a.labels"); });
  };
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_TRUE(reading(whole.substr(0, size)).code) << size;
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const char byte : {'\0', '\x7F'}) {
      std::string damaged = whole;
      damaged[at] = byte;
      const auto caught = reading(damaged);
      EXPECT_TRUE(caught.code || at >= magicVersionAndDigest || byte == whole[at]) << at;
    }
}

TEST(LabelFile, SaysWhatItIsNot) {
  const test::ScratchFolder scratch;
  test::writeFile(scratch / "text.labels", "cup\ncat\n");
  EXPECT_THAT([&] { readDescriptors(scratch / "text.labels"); }, FailsWith(ErrorCode::unsupportedFile));
  writeDescriptors(sample(), scratch / "new.labels");
  std::string newer = test::readFile(scratch / "new.labels");
  newer[8] = 2;
  test::writeFile(scratch / "new.labels", newer);
  EXPECT_THAT([&] { readDescriptors(scratch / "new.labels"); }, FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT([&] { writeDescriptors(sample(), scratch / "words.txt"); },
              FailsWith(ErrorCode::unsupportedFile));
}

TEST(DescriptorSequence, IsPutInOtherWords) {
  const DescriptorSequence other = toVocabulary(sample(), Vocabulary({"kitchen", "dog", "cup"}));
  EXPECT_THAT(other.descriptors.row(0), ElementsAre(1, 0, 0.1F));
  EXPECT_EQ(other.frames.size(), 2U);
  DescriptorSequence cranes{
      Vocabulary({"cup", "crane", "crane"}), "m", {{"a", {}, {}, ""}}, DescriptorMatrix(3)};
  cranes.descriptors.append(LexicalDescriptor{0.1F, 0.7F, 0.2F});
  EXPECT_THAT(toVocabulary(cranes, Vocabulary({"crane", "cup", "crane"})).descriptors.row(0),
              ElementsAre(0.7F, 0.1F, 0.2F));
}

}  // namespace
}  // namespace estancia
