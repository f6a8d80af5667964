#include "rivid/output.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/complaint.hpp"
#include "support/temporary_folder.hpp"

namespace {

using rivid::Outputs;
using rivid::write_file;
using rivid::test::TemporaryFolder;
using Path = std::filesystem::path;

class Output : public testing::Test {
 protected:
  [[nodiscard]] Path in_folder(const std::string& name) const { return folder.path() / name; }

  [[nodiscard]] mode_t mode(const std::string& name) const {
    struct stat status{};
    EXPECT_EQ(::stat(in_folder(name).c_str(), &status), 0);
    return status.st_mode & 07777;
  }

  [[nodiscard]] std::string refusal(const std::vector<Path>& inputs, const std::vector<Path>& planned,
                                    bool force = false) const {
    return rivid::test::complaint_of([&] {
      Outputs outputs(inputs, force);
      for (const Path& path : planned) {
        outputs.plan(path, ".json");
      }
    });
  }

  TemporaryFolder folder;
};

TEST_F(Output, OfAllOrNoFiles) {
  folder.write("a.json", "old");
  {
    Outputs outputs;
    outputs.plan(in_folder("a.json"), ".json");
    outputs.plan(in_folder("b.json"), ".json");
    outputs.put(in_folder("a.json"), "new a");
    outputs.put(in_folder("b.json"), "new b");
    EXPECT_EQ(folder.read("a.json"), "old");
  }
  EXPECT_EQ(folder.entries(), std::vector{in_folder("a.json").string()})
      << "what is not committed is dropped";
  Outputs outputs;
  outputs.plan(in_folder("a.json"), ".json");
  outputs.plan(in_folder("sub/b.json"), ".json");
  outputs.put(in_folder("a.json"), "new a");
  outputs.put(in_folder("sub/b.json"), "new b");
  outputs.commit();
  EXPECT_EQ(folder.read("a.json"), "new a");
  EXPECT_EQ(folder.read("sub/b.json"), "new b");
  EXPECT_EQ(folder.entries().size(), 3U);
}

TEST_F(Output, IsRefusedWhereItIsAnInputByWhateverName) {
  folder.write("log.json", "an input");
  std::filesystem::create_symlink("log.json", in_folder("link.json"));
  std::filesystem::create_hard_link(in_folder("log.json"), in_folder("hard.json"));
  for (const char* const name : {"log.json", "./log.json", "link.json", "hard.json", "../x/log.json"}) {
    const Path path = std::string(name).starts_with("../x")
                          ? folder.path() / ".." / folder.path().filename() / "log.json"
                          : in_folder(name);
    const std::string words = refusal({in_folder("log.json")}, {path}, true);
    EXPECT_NE(words.find("is an input of this run"), std::string::npos) << name << ": " << words;
  }
}

TEST_F(Output, IsRefusedWhereTwoHaveOneName) {
  std::filesystem::create_directories(in_folder("sub"));
  std::filesystem::create_symlink("nowhere.json", in_folder("link.json"));
  for (const auto& [a, b] :
       std::vector<std::pair<std::string, std::string>>{{"r.json", "r.json"},
                                                        {"r.json", "sub/../r.json"},
                                                        {"nowhere.json", "link.json"},
                                                        {"new/r.json", "new/./r.json"}}) {
    const std::string words = refusal({}, {in_folder(a), in_folder(b)});
    EXPECT_NE(words.find("is written twice in this run"), std::string::npos)
        << a << " " << b << ": " << words;
  }
}

TEST_F(Output, IsRefusedWhereNoRegularFileIsThere) {
  ASSERT_EQ(::mkfifo(in_folder("pipe.json").c_str(), 0600), 0);
  std::filesystem::create_directories(in_folder("folder.json"));
  EXPECT_NE(refusal({}, {in_folder("pipe.json")}, true).find("is no regular file"), std::string::npos);
  EXPECT_NE(refusal({}, {"/dev/null"}, true).find("is no regular file"), std::string::npos);
  EXPECT_NE(refusal({}, {in_folder("folder.json")}, true).find("Is a directory"), std::string::npos);
  EXPECT_NE(refusal({}, {in_folder("new") / ""}, true).find("names a folder"), std::string::npos);
  EXPECT_THROW(write_file("/dev/null", "x"), rivid::InputError);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST_F(Output, OfAnotherKindThanWhatIsThereNeedsForce) {
  folder.write("log.csv", "t,q1\n");
  EXPECT_NE(refusal({}, {in_folder("log.csv")}).find("is no .json file"), std::string::npos);
  EXPECT_EQ(refusal({}, {in_folder("log.csv")}, true), "");
  EXPECT_EQ(refusal({}, {in_folder("new.csv")}), "") << "nothing is lost where nothing is";
}

TEST_F(Output, KeepsTheModeOfAFileAndObeysTheUmask) {
  folder.write("secret.json", "old");
  std::filesystem::permissions(in_folder("secret.json"), std::filesystem::perms(0600));
  write_file(in_folder("secret.json"), "new");
  EXPECT_EQ(mode("secret.json"), 0600U);
  const mode_t before = ::umask(027);
  write_file(in_folder("new.json"), "new");
  ::umask(before);
  EXPECT_EQ(mode("new.json"), 0640U);
}

TEST_F(Output, KeepsTheOwnerOfAFile) {
  if (::geteuid() != 0) {
    GTEST_SKIP() << "root alone can give files away";
  }
  folder.write("theirs.json", "old");
  ASSERT_EQ(::chown(in_folder("theirs.json").c_str(), 1234, 1235), 0);
  write_file(in_folder("theirs.json"), "new");
  struct stat status{};
  ASSERT_EQ(::stat(in_folder("theirs.json").c_str(), &status), 0);
  EXPECT_EQ(status.st_uid, 1234U);
  EXPECT_EQ(status.st_gid, 1235U);
}

TEST_F(Output, GoesWhereSymbolicLinksLead) {
  folder.write("real.json", "old");
  std::filesystem::create_symlink("real.json", in_folder("one.json"));
  std::filesystem::create_symlink("one.json", in_folder("two.json"));
  std::filesystem::create_symlink("missing.json", in_folder("dangling.json"));
  write_file(in_folder("two.json"), "new");
  write_file(in_folder("dangling.json"), "first");
  EXPECT_EQ(folder.read("real.json"), "new");
  EXPECT_EQ(folder.read("missing.json"), "first");
  for (const char* const link : {"one.json", "two.json", "dangling.json"}) {
    EXPECT_TRUE(std::filesystem::is_symlink(in_folder(link))) << link;
  }
}

TEST_F(Output, MayHaveTheLongestNameThereIs) {
  std::string name(250, 'n');
  name += ".json";
  write_file(in_folder(name), "content");
  EXPECT_EQ(folder.read(name), "content");
}

TEST_F(Output, SweepsWhatAKilledProgramLeftAndNothingElse) {
  folder.write(".rivid-abc234", "of a killed program");
  folder.write(".rivid-notes", "of a user");
  folder.write(".rivid-abc2345", "of a user");
  folder.write(".rivid-xyz234", "of a program that runs");
  const int held = ::open(in_folder(".rivid-xyz234").c_str(), O_RDONLY);
  ASSERT_EQ(::flock(held, LOCK_EX), 0);
  write_file(in_folder("a.json"), "content");
  ::close(held);
  EXPECT_EQ(folder.entries(),
            (std::vector{in_folder(".rivid-abc2345").string(), in_folder(".rivid-notes").string(),
                         in_folder(".rivid-xyz234").string(), in_folder("a.json").string()}));
}

TEST_F(Output, SaysWhichFileCanNotBeWritten) {
  folder.write("file", "");
  EXPECT_NE(refusal({}, {in_folder("file/r.json")}).find("file/r.json: can not be written: Not a directory"),
            std::string::npos);
  if (::geteuid() != 0) {
    folder.write("r.json", "");
    std::filesystem::permissions(in_folder("r.json"), std::filesystem::perms(0400));
    EXPECT_NE(refusal({}, {in_folder("r.json")}).find("Permission denied"), std::string::npos);
  }
}

}  // namespace
