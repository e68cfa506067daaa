// Folders of images, of classes of images, and the files beside them.
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include "estancia/sequences/descriptor_sequence.hpp"
#include "readers/sequence_folder.hpp"

namespace estancia {
namespace {

namespace fs = std::filesystem;
using test::FailsWith;
using test::Mentions;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class ImageFolder : public test::SequenceFolder {
 protected:
  std::vector<std::string> names() { return test::namesOf(*open()); }
};

TEST_F(ImageFolder, IsReadInNaturalOrderWhateverTheCaseOfSuffixes) {
  for (const char* name : {"img10.PNG", "img9.png", "img1.JPEG", "img2.Tif"}) add(name);
  write("notes.txt", "no image");
  write(".hidden.png", "");
  fs::create_directories(folder_ / "img3.png");
  EXPECT_THAT(names(), ElementsAre("img1.JPEG", "img2.Tif", "img9.png", "img10.PNG"));
  const auto sequence = open();
  EXPECT_EQ(sequence->name(), folder_.path().filename());
  EXPECT_FALSE(sequence->frame(0).timestamp || sequence->frame(0).pose);
  EXPECT_EQ(sequence->frame(0).room, "");
  EXPECT_THAT(sequence->warnings(), IsEmpty());
  EXPECT_EQ(openSequence(folder_.path() / "")->name(), folder_.path().filename());
}

TEST_F(ImageFolder, TakesNamesWithBlanksUmlautsAndLineEnds) {
  for (const char* name : {"a b.png", "habitación.png", "two\nlines.png", "latin\xE9.png"}) add(name, 7);
  EXPECT_THAT(names(), ElementsAre("a b.png", "habitación.png", "latin\\xE9.png", "two\\x0Alines.png"));
  const auto sequence = open();
  for (std::size_t i = 0; i < sequence->size(); ++i) EXPECT_EQ(sequence->image(i).at<cv::Vec3b>(0, 0)[0], 7);
}

TEST_F(ImageFolder, GoesOnBehindATruncatedImage) {
  const std::string jpeg = test::encoded(".jpg", test::texture(32, 24));
  for (const char* name : {"0.jpg", "1.jpg", "2.jpg"})
    write(name, name[0] == '1' ? jpeg.substr(0, jpeg.size() / 2) : jpeg);
  const auto sequence = open();
  ASSERT_EQ(sequence->size(), 3U);
  EXPECT_FALSE(sequence->image(0).empty());
  EXPECT_THAT([&] { sequence->image(1); }, FailsWith(ErrorCode::truncatedFile));
  EXPECT_FALSE(sequence->image(2).empty());
}

TEST_F(ImageFolder, SaysWhenThereIsNothingToRead) {
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsupportedFile));
  options_.type = "folder";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::insufficientData));
  EXPECT_THAT([&] { openSequence(folder_ / "none"); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT([&] { openSequence(""); }, FailsWith(ErrorCode::fileNotFound));
  ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_THAT([&] { openSequence(folder_ / "pipe"); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(ImageFolder, EachTypeRefusesAFolderThatIsNone) {
  write("notes.txt", "no image");
  for (const auto& [type, words] : sequenceTypes()) EXPECT_TRUE(refusal({.type = type}).code) << type;
  EXPECT_THAT(refusal({.type = "rgbd"}), FailsWith(ErrorCode::insufficientData));
}

TEST_F(ImageFolder, LeavesOutImagesOfOtherFormatsAndOfItsFolders) {
  write("a.heic", "photograph");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_THAT(refusal({.type = "folder"}), FailsWith(ErrorCode::insufficientData));
  write("b.CR2", "photograph");
  add("monday/1.png");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsupportedFile));
  for (const char* name : {"tuesday/1.png", "train/hall/1.png"}) add(name);
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsupportedFile));
  for (const char* name : {"1.png", "2.png"}) add(name);
  EXPECT_THAT(open()->warnings(), ElementsAre(Mentions({"2", "a.heic"})));
}

TEST_F(ImageFolder, FilesAreASequenceInTheOrderInWhichTheyAreNamed) {
  for (const char* name : {"b.png", "a.png"}) add(name);
  write("notes.txt", "no image");
  const auto sequence = openImages({folder_ / "b.png", folder_ / "a.png"});
  EXPECT_THAT(test::namesOf(*sequence), ElementsAre(folder_ / "b.png", folder_ / "a.png"));
  EXPECT_EQ(openImages({folder_ / "a.png"})->name(), "a.png");
  EXPECT_THAT([] { openImages({}); }, FailsWith(ErrorCode::invalidInput));
  EXPECT_THAT([&] { openImages({folder_ / "c.png"}); }, FailsWith(ErrorCode::fileNotFound));
  EXPECT_THAT([&] { openImages({folder_ / "notes.txt"}); }, FailsWith(ErrorCode::unsupportedFile));
}

TEST_F(ImageFolder, ListedFramesGetNamesOfTheirOwnAndOddTimesAreTold) {
  DescriptorSequence listed{Vocabulary({"cup"}), "m", {}, DescriptorMatrix(1)};
  listed.frames = {{"a", 2.0, {}, "Kitchen"}, {"a", 1.0, {}, "kitchen"}, {"b", {}, {}, ""}};
  for (int i = 0; i < 3; ++i) listed.descriptors.append(LexicalDescriptor{0.5F});
  writeDescriptors(listed, folder_ / "a.labels");
  const auto sequence = openSequence(folder_ / "a.labels");
  EXPECT_THAT(test::namesOf(*sequence), ElementsAre("a", "a (2)", "b"));
  EXPECT_NE(sequence->fingerprint(0), "");
  EXPECT_THAT(sequence->warnings(), ElementsAre(Mentions({"1"}), Mentions({"1 of 3", "a (2)"}),
                                                Mentions({"1 of 3"}), Mentions({"Kitchen", "kitchen"})));
}

TEST_F(ImageFolder, SurvivesCyclesOfSymbolicLinks) {
  add("1.png");
  add("2.png");
  fs::create_symlink("loop.png", folder_ / "loop.png");
  fs::create_symlink("gone", folder_ / "dangling.png");
  fs::create_symlink(folder_.path(), folder_ / "self");
  EXPECT_THAT(names(), ElementsAre("1.png", "2.png"));
  EXPECT_EQ(openSequence(folder_ / "self" / "self")->size(), 2U);
  EXPECT_THAT([&] { openSequence(folder_ / "loop.png"); }, FailsWith(ErrorCode::fileUnreadable));
}

TEST_F(ImageFolder, RefusesUnknownTypesAndListsTheKnown) {
  add("1.png");
  options_.type = "movie";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unknownName));
  EXPECT_EQ(sequenceTypes().size(), 12U);
}

TEST_F(ImageFolder, TakesTimeStampsFromNamesThatAreSuch) {
  add("1305031102.175304.png");
  add("1305031102.211214.png");
  EXPECT_EQ(open()->frame(1).timestamp, 1305031102.211214);
  add("overview.png");
  EXPECT_FALSE(open()->frame(1).timestamp);
}

TEST_F(ImageFolder, MatchesPosesByTimeAndNeverAcrossAGap) {
  for (const char* name : {"10.000.png", "11.000.png", "12.000.png", "13.000.png"}) add(name);
  write("truth/t.txt",
        "12.04 3 0 0 0 0 0 1\n10.01 1 0 0 0 0 0 1\n11.5 2 0 0 0 0 0 1\n12.96 9 0 0 0 0 0 1\n13.01 nan 0 0 0 "
        "0 0 1\n");
  options_.poses = folder_ / "truth" / "t.txt";
  const auto sequence = open();
  EXPECT_EQ(sequence->frame(0).pose->x, 1);
  EXPECT_FALSE(sequence->frame(1).pose);
  EXPECT_EQ(sequence->frame(2).pose->x, 3);
  EXPECT_FALSE(sequence->frame(3).pose) << "the nearest pose is NaN: another one would be a guess";
  EXPECT_THAT(sequence->warnings(), ::testing::Contains(Mentions({"1 of 4", "0.05"})));
  EXPECT_THAT(sequence->warnings(), ::testing::Contains(Mentions({"1 of 5"})));
  EXPECT_THAT(sequence->warnings(), ::testing::Contains(Mentions({"2 of 5"})));
  options_.maxPoseGap = 0.6;
  EXPECT_EQ(open()->frame(1).pose->x, 2);
  options_.maxPoseGap = -1;
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::invalidOption));
}

TEST_F(ImageFolder, MatchesPosesByOrderWhereThereAreNoTimes) {
  add("a.png");
  add("b.png");
  write("poses.txt", "1 0 0 0 0 0 0 1\n2 5 0 0 0 0 0 0\n");
  const auto sequence = open();
  EXPECT_EQ(sequence->frame(0).pose->x, 0);
  EXPECT_FALSE(sequence->frame(1).pose) << "a zero quaternion";
  write("poses.txt", "1 0 0 0  0 1 0 7  0 0 1 0\n1 0 0 0  0 1 0 8  0 0 1 0\n");  // KITTI
  EXPECT_EQ(open()->frame(1).pose->y, 8);
}

TEST_F(ImageFolder, RefusesNamedPosesThatFitNothingButOnlyMentionsFoundOnes) {
  add("a.png");
  add("b.png");
  write("poses.txt", "1 0 0 0 0 0 0 1\n");
  const auto sequence = open();
  EXPECT_FALSE(sequence->frame(0).pose);
  EXPECT_THAT(sequence->warnings(), ElementsAre(Mentions({"poses.txt", "1", "2"})));
  options_.poses = folder_ / "poses.txt";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::mismatch));
  options_.poses = folder_ / "none.txt";
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::fileNotFound));
}

TEST_F(ImageFolder, TakesRoomsWithAndWithoutHeader) {
  add("a, b.png");
  add("c.png");
  write("rooms.csv", "image,room\n\"a, b.png\",kitchen\nsome/folder/c.png,\"the \"\"hall\"\"\"\n");
  EXPECT_EQ(open()->frame(0).room, "kitchen");
  EXPECT_EQ(open()->frame(1).room, "the \"hall\"");
  EXPECT_THAT(open()->warnings(), IsEmpty());
  write("elsewhere/r.csv", "c.png,office\n");
  options_.rooms = folder_ / "elsewhere" / "r.csv";
  EXPECT_EQ(open()->frame(0).room, "");
  EXPECT_EQ(open()->frame(1).room, "office");
}

TEST_F(ImageFolder, RefusesAWrongRoomsFile) {
  add("a.png");
  add("b.png");
  options_.rooms = folder_ / "r.csv";
  for (const char* text :
       {"a.png,kitchen\nb.png,hall,3\n", "a.png,kitchen\na.png,hall\n", "a.png,kitchen,train\nb.png,hall\n",
        "a.png,kitchen,train\na.png,kitchen,test\n"}) {
    write("r.csv", text);
    EXPECT_THAT(refusal(), FailsWith(ErrorCode::malformedFile)) << text;
  }
}

class Classes : public test::SequenceFolder {
 protected:
  static std::vector<std::string> told(const Sequence& sequence) {
    std::vector<std::string> all = test::namesOf(sequence);
    for (std::size_t i = 0; i < all.size(); ++i) all[i] += "=" + sequence.frame(i).room;
    return all;
  }
};

TEST_F(Classes, AreTheFoldersOfTheImages) {
  for (const char* name :
       {"kitchen/image_10.png", "kitchen/image_9.png", "bedroom/image_9.png", "MITforest/a.png"})
    add(name);
  add("kitchen/image_2.png", 77);
  write("kitchen/notes.txt", "no image");
  write(".git/image.png", "");
  const auto sequence = open({.type = "classes"});
  EXPECT_THAT(told(*sequence), ElementsAre("MITforest/a.png=MITforest", "bedroom/image_9.png=bedroom",
                                           "kitchen/image_2.png=kitchen", "kitchen/image_9.png=kitchen",
                                           "kitchen/image_10.png=kitchen"));
  EXPECT_EQ(sequence->image(2).at<cv::Vec3b>(0, 0)[0], 77);
  EXPECT_FALSE(sequence->hasDepth());
  EXPECT_THAT(sequence->warnings(), IsEmpty());
}

TEST_F(Classes, HalvesOfTheSameClassesAreFoundByThemselves) {
  for (const char* name : {"train/hall/1.png", "train/office/1.png", "train/office/2.png", "test/hall/1.png",
                           "test/office/1.png"})
    add(name);
  EXPECT_EQ(open()->size(), 5U);
  EXPECT_THAT(told(*open({.split = "train"})),
              ElementsAre("train/hall/1.png=hall", "train/office/1.png=office", "train/office/2.png=office"));
  EXPECT_THAT(told(*open({.type = "classes", .split = "test"})),
              ElementsAre("test/hall/1.png=hall", "test/office/1.png=office"));
  EXPECT_THAT(refusal({.split = "val"}), FailsWith(ErrorCode::unknownName));
}

TEST_F(Classes, OtherFoldersAreTakenForClassesOnlyWhenAskedFor) {
  add("2026-11-01/1.png");
  add("2026-11-02/1.png");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_EQ(open({.type = "classes"})->size(), 2U);
  add("0.png");
  EXPECT_THAT(told(*open()), ElementsAre("0.png=")) << "images of its own make it a plain folder";
}

TEST_F(Classes, WithoutImagesAreRefused) {
  EXPECT_THAT(refusal({.type = "classes"}), FailsWith(ErrorCode::insufficientData));
  write("file", "x");
  SequenceOptions options;
  options.type = "classes";
  EXPECT_TRUE(test::caught([&] { openSequence(folder_ / "file", options); }).code);
}

TEST_F(Classes, TellWhatIsLeftOut) {
  add("train/hall/1.png");
  add("readme.png");
  add("extra/1.png");
  std::filesystem::create_directories(folder_ / "train/empty");
  const auto sequence = open({.type = "classes"});
  EXPECT_THAT(told(*sequence), ElementsAre("train/hall/1.png=hall"));
  EXPECT_THAT(sequence->warnings(),
              ::testing::IsSupersetOf({Mentions({"1 image"}), Mentions({"2 folders", "extra/"})}));
}

TEST_F(Classes, HalvesOfDifferentClassesAreNotFoundByThemselves) {
  add("train/hall/1.png");
  add("train/office/1.png");
  add("test/hall/1.png");
  EXPECT_THAT(refusal(), FailsWith(ErrorCode::unsupportedFile));
  EXPECT_EQ(open({.type = "classes", .split = "train"})->size(), 2U);
}

TEST_F(ImageFolder, CountsRoomsOfImagesThatAreNotThere) {
  add("a.png");
  add("b.png");
  write("rooms.csv", "a.png,kitchen\nx.png,hall\ny.png,hall\n");
  EXPECT_THAT(open()->warnings(), ElementsAre(Mentions({"2 of 3", "x.png"})));
}

}  // namespace
}  // namespace estancia
