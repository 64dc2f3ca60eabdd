// Covers engine/study/protocol/texts.h and the German texts of docs/study_protocol.md.
#include "engine/study/protocol/texts.h"

#include "tests/engine/study/protocol/plain_protocol.h"
#include "tests/support/files.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace springdrive::study {
namespace {

TEST(Texts, AllAreInTheList) {
    std::set<std::string_view> keys;
    std::set<const std::string *> texts;
    const Texts by_default;
    for (const ParticipantText &one : kParticipantTexts) {
        keys.insert(one.key);
        texts.insert(&(by_default.*one.text));
        EXPECT_FALSE((by_default.*one.text).empty()) << one.key;
        EXPECT_FALSE(one.help.empty()) << one.key;
    }
    EXPECT_EQ(keys.size(), kParticipantTexts.size());
    EXPECT_EQ(texts.size(), kParticipantTexts.size());
    EXPECT_EQ(sizeof(Texts), kParticipantTexts.size() * sizeof(std::string)) << "and no other";
    EXPECT_EQ(what_is_wrong_with(by_default), "");
}

TEST(Texts, PlaceholdersAreFilledIn) {
    EXPECT_EQ(filled("noch {} s", "{}", "12"), "noch 12 s");
    EXPECT_EQ(filled("{}", "{}", "{}"), "{}") << "once only";
    EXPECT_EQ(filled(filled("{begin}, {again}", "{again}", "n"), "{begin}", "y"), "y, n");
    EXPECT_EQ(filled("none", "{}", "12"), "none");
}

TEST(Texts, EachPlaceholderIsThereOnce) {
    for (const ParticipantText &one : kParticipantTexts) {
        Texts texts;
        std::string all;
        for (const std::string_view placeholder : one.placeholders) {
            all += placeholder;
        }
        texts.*one.text = "a " + all;
        EXPECT_EQ(what_is_wrong_with(texts), "") << one.key;
        texts.*one.text = "a " + all + all;
        EXPECT_EQ(what_is_wrong_with(texts).empty(), all.empty()) << one.key;
        texts.*one.text = "a";
        EXPECT_EQ(what_is_wrong_with(texts).empty(), all.empty()) << one.key;
        texts.*one.text = "a {other} " + all;
        EXPECT_EQ(what_is_wrong_with(texts).rfind(std::string(one.key) + " has '{other}'", 0), 0U)
            << one.key;
    }
    Texts smiling;
    smiling.end = "Thank you :-}";
    EXPECT_EQ(what_is_wrong_with(smiling), "");
}

/// The first block of TOML after a heading of a page.
std::string toml_after(const std::string &page, const std::string &heading) {
    const std::size_t at = page.find(heading);
    EXPECT_NE(at, std::string::npos) << heading;
    const std::string opening = "```toml\n";
    const std::size_t from = page.find(opening, at) + opening.size();
    return page.substr(from, page.find("```", from) - from);
}

/// The page's German texts are complete, and a shipped protocol may have them.
TEST(Texts, TheManualHasThemInGerman) {
    const std::string german =
        toml_after(testing::contents_of(testing::assets().parent_path() / "docs/study_protocol.md"),
                   "## In another language");
    std::string direction =
        testing::contents_of(testing::assets() / "protocols" / "direction.toml");
    const std::size_t from = direction.find("[texts]");
    direction.replace(from, direction.find("# What all conditions", from) - from, german);
    const Protocol protocol = testing::protocol_of(direction);
    EXPECT_EQ(protocol.language, "de");
    for (const ParticipantText &one : kParticipantTexts) {
        EXPECT_NE(german.find("\n" + std::string(one.key) + " = "), std::string::npos) << one.key;
    }
    EXPECT_NE(protocol.texts, Texts{});
}

} // namespace
} // namespace springdrive::study
