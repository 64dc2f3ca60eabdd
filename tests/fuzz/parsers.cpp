// What libFuzzer calls with one input after the other: a parser of the program's files, which has
// to read each input or refuse it with an InputError. SPRINGDRIVE_PARSER names the parser; see
// tests/fuzz/run.
#include "base/input_error.h"
#include "device/core/device_file.h"
#include "device/simulated/hand.h"
#include "engine/contact/mesh/mesh_report.h"
#include "engine/contact/proxy/haptic_surface.h"
#include "engine/control/tuning_file.h"
#include "engine/record/record_file.h"
#include "engine/scene/gltf.h"
#include "engine/study/protocol/protocol.h"

#include <fmt/core.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace {

using namespace springdrive;
namespace fs = std::filesystem;

void read_scene(const fs::path &file) {
    const scene::Scene scene = scene::load_gltf(file, device::Workspace{});
    constexpr std::size_t kQuicklyPrepared = 10'000;
    if (scene.surface.triangles.size() <= kQuicklyPrepared) {
        const contact::HapticSurface surface(scene.surface, scene.shapes);
        static_cast<void>(contact::warnings_about(surface.report(), surface.materials()));
    }
}

void read_record(const fs::path &file) {
    record::RecordReader reader(file);
    while (reader.next()) {
        for (std::uint32_t row = 0; row < reader.rows(); ++row) {
            static_cast<void>(reader.read_sample(row));
        }
    }
    static_cast<void>(reader.ending().text());
}

struct Parser {
    void (*read)(const fs::path &);
    std::string_view file_name; ///< some are told apart by their endings
};

const std::map<std::string_view, Parser> kParsers{
    {"glb", {read_scene, "input.glb"}},
    {"gltf", {read_scene, "input.gltf"}},
    {"device",
     {[](const fs::path &file) { static_cast<void>(device::read_device_file(file)); },
      "input.toml"}},
    {"tuning",
     {[](const fs::path &file) { static_cast<void>(control::read_whole_tuning_file(file)); },
      "input.toml"}},
    {"protocol",
     {[](const fs::path &file) { static_cast<void>(study::read_protocol_file(file)); },
      "input.toml"}},
    {"hand-path",
     {[](const fs::path &file) { static_cast<void>(simulated::HandPath::read_csv(file)); },
      "input.csv"}},
    {"record", {read_record, "input.springdrive"}},
};

[[nodiscard]] const Parser &parser() {
    const char *const name = std::getenv("SPRINGDRIVE_PARSER");
    const auto found = kParsers.find(name == nullptr ? "" : name);
    if (found == kParsers.end()) {
        fmt::print(stderr, "SPRINGDRIVE_PARSER has to be one of:");
        for (const auto &[known, parser] : kParsers) {
            fmt::print(stderr, " {}", known);
        }
        fmt::print(stderr, "\n");
        std::exit(2);
    }
    return found->second;
}

/// A folder in memory, one for each process.
[[nodiscard]] fs::path make_folder() {
    fs::path folder = fs::path("/dev/shm") / fmt::format("springdrive_fuzz_{}", getpid());
    fs::create_directories(folder);
    return folder;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    static const Parser &chosen = parser();
    static const fs::path file = make_folder() / chosen.file_name;
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char *>(data), // NOLINT(*-reinterpret-cast): bytes
               static_cast<std::streamsize>(size));
    try {
        chosen.read(file);
    } catch (const InputError &error) {
        // One line that names the file.
        const std::string_view text = error.what();
        if (text.find('\n') != std::string_view::npos ||
            text.find(file.filename().string()) == std::string_view::npos) {
            fmt::print(stderr, "not one line with the file's name: {}\n", text);
            std::abort();
        }
    }
    return 0;
}
