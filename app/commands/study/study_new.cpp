#include "app/commands/study/study_commands.h"

#include "app/commands/output_files.h"
#include "app/host/asset_folder.h"
#include "base/input_error.h"
#include "engine/study/protocol/protocol_file.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace springdrive::app {

namespace {

namespace fs = std::filesystem;

fs::path protocol_folder() { return asset_folder() / "protocols"; }

/// Of the protocols that are included, in the order of the alphabet.
std::vector<std::string> included_protocols() {
    std::vector<std::string> names;
    for (const fs::directory_entry &entry : fs::directory_iterator(protocol_folder())) {
        if (entry.path().extension() == ".toml") {
            names.push_back(entry.path().stem().string());
        }
    }
    std::ranges::sort(names);
    return names;
}

struct TypedNewProtocol {
    std::string name;
    std::string out; ///< empty: NAME.toml
    bool lists = false;
};

void list_protocols() {
    for (const std::string &name : included_protocols()) {
        const study::Protocol protocol =
            study::read_protocol_file(protocol_folder() / (name + ".toml"));
        std::cout << fmt::format("{:<12} {}\n", name, protocol.title);
    }
}

void write_new(const TypedNewProtocol &typed) {
    if (typed.lists) {
        list_protocols();
        return;
    }
    const std::vector<std::string> names = included_protocols();
    if (std::ranges::count(names, typed.name) == 0) {
        std::string all;
        for (const std::string &name : names) {
            all += (all.empty() ? "" : ", ") + name;
        }
        throw InputError("study new " + typed.name + ": no such protocol; there are " + all);
    }
    const fs::path out = typed.out.empty() ? fs::path(typed.name + ".toml") : fs::path(typed.out);
    if (typed.out != "-" && fs::exists(out)) {
        throw InputError(out.string() + ": exists; name another file with --out");
    }
    std::ifstream source(protocol_folder() / (typed.name + ".toml"), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(source), {}};
    write_output(
        out.string(), [&text](std::ostream &stream) { stream << text; }, Existing::keep);
    if (typed.out != "-") {
        std::cerr << "written: " << out.string() << "\nedit it, then: springdrive study check "
                  << out.string() << '\n';
    }
}

} // namespace

void add_study_new_command(Command &study) {
    Command command =
        study.add_subcommand("new", "writes an included protocol, to be edited and run");
    const auto typed = std::make_shared<TypedNewProtocol>();
    Option name = command.add_option("name", typed->name, "which protocol, see --list");
    name.type_name("NAME");
    command
        .add_option("--out", typed->out,
                    "where to [NAME.toml]; - for standard output. An existing file is kept")
        .type_name("FILE");
    Option list = command.add_flag("--list", typed->lists, "the included protocols");
    list.excludes(name);
    command.callback([typed] {
        if (!typed->lists && typed->name.empty()) {
            throw InputError("study new: which protocol? springdrive study new --list tells them");
        }
        write_new(*typed);
    });
}

} // namespace springdrive::app
