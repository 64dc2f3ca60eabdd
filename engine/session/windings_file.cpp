#include "engine/session/windings_file.h"

#include "base/input_error.h"
#include "base/new_file.h"
#include "base/sha256.h"
#include "device/core/motor/winding_heat.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <ctime>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <optional>
#include <ostream>
#include <system_error>
#include <unistd.h>

namespace springdrive::session {

namespace {

using Motors = std::array<device::MotorTemperature, 3>;

constexpr std::size_t kMaxBytes = 4096;
constexpr double kMax_C = 1000.0; ///< no winding survives it

struct Stored {
    std::string serial;
    StoringTime at;
    Motors hottest;
};

/// Of all but its checksum: keys are in the order of their letters, numbers exact.
std::string checksum(nlohmann::json json) {
    json.erase("sha256");
    Sha256 digest;
    digest.add(json.dump());
    return digest.hex();
}

nlohmann::json json_of(const Stored &stored) {
    nlohmann::json json{{"serial", stored.serial},
                        {"utc_s", stored.at.utc_s},
                        {"boot", stored.at.boot},
                        {"since_boot_s", stored.at.since_boot_s}};
    for (const device::MotorTemperature &motor : stored.hottest) {
        json["winding_C"].push_back(motor.winding_C);
        json["housing_C"].push_back(motor.housing_C);
    }
    json["sha256"] = checksum(json);
    return json;
}

std::optional<Stored> read(const std::filesystem::path &file) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored) ||
        std::filesystem::file_size(file, ignored) > kMaxBytes) {
        return std::nullopt;
    }
    std::ifstream stream(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    try {
        const nlohmann::json json = nlohmann::json::parse(text);
        if (json.at("sha256").get<std::string>() != checksum(json)) {
            return std::nullopt;
        }
        Stored stored{json.at("serial").get<std::string>(),
                      {json.at("utc_s").get<std::int64_t>(), json.at("boot").get<std::string>(),
                       json.at("since_boot_s").get<double>()},
                      {}};
        for (std::size_t j = 0; j < stored.hottest.size(); ++j) {
            stored.hottest[j] = {json.at("winding_C").at(j).get<double>(),
                                 json.at("housing_C").at(j).get<double>()};
        }
        return stored;
    } catch (const nlohmann::json::exception &) {
        return std::nullopt;
    }
}

/// Gone for good, also after a power failure: what it says will be wrong by then.
bool is_removed(const std::filesystem::path &file) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
    if (std::filesystem::exists(std::filesystem::symlink_status(file, ignored))) {
        return false;
    }
    const int folder = open(file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool is_kept = folder < 0 || fsync(folder) == 0;
    if (folder >= 0) {
        close(folder);
    }
    return is_kept;
}

bool is_usable(const Stored &stored, const std::string &serial, const StoringTime &now) {
    const auto is_possible = [](double celsius) {
        return celsius >= device::kColdestAir_C && celsius <= kMax_C; // not for NaN
    };
    return stored.serial == serial && stored.at.utc_s <= now.utc_s &&
           std::ranges::all_of(stored.hottest, [&](const device::MotorTemperature &motor) {
               return is_possible(motor.winding_C) && is_possible(motor.housing_C);
           });
}

} // namespace

StoringTime storing_time() {
    StoringTime now;
    now.utc_s = std::time(nullptr);
    std::ifstream("/proc/sys/kernel/random/boot_id") >> now.boot;
    timespec since_boot{};
    if (clock_gettime(CLOCK_BOOTTIME, &since_boot) != 0) {
        now.boot.clear();
    }
    now.since_boot_s =
        static_cast<double>(since_boot.tv_sec) + 1e-9 * static_cast<double>(since_boot.tv_nsec);
    return now;
}

std::filesystem::path windings_file(const std::filesystem::path &folder,
                                    const std::string &serial) {
    if (folder.empty()) {
        return {};
    }
    Sha256 digest;
    digest.add(serial);
    constexpr std::size_t kEnough = 16;
    return folder / (digest.hex().substr(0, kEnough) + ".json");
}

Motors take_windings(const std::filesystem::path &folder, const std::string &serial,
                     const std::array<device::MotorParameters, 3> &motors, const StoringTime &now) {
    Motors hottest = device::hottest_motors(motors);
    const std::filesystem::path file = windings_file(folder, serial);
    if (file.empty()) {
        return hottest;
    }
    const std::optional<Stored> stored = read(file);
    if (!is_removed(file) || !stored || !is_usable(*stored, serial, now)) {
        return hottest;
    }
    if (now.boot.empty() || stored->at.boot != now.boot) {
        return stored->hottest;
    }
    const double passed_s = now.since_boot_s - stored->at.since_boot_s;
    if (!(passed_s >= 0.0)) {
        return hottest;
    }
    for (std::size_t j = 0; j < hottest.size(); ++j) {
        device::WindingTemperature motor(motors[j].thermal, device::kWarmestAir_C, passed_s);
        motor.raise_to(stored->hottest[j]);
        motor.update(0.0);
        hottest[j] = motor.temperature();
    }
    return hottest;
}

bool store_windings(const std::filesystem::path &folder, const std::string &serial,
                    const Motors &hottest, const StoringTime &now) {
    const std::filesystem::path file = windings_file(folder, serial);
    if (file.empty()) {
        return false;
    }
    try {
        std::filesystem::create_directories(folder);
        write_file(
            file,
            [&](std::ostream &out) {
                out << json_of({serial, now, hottest}) << '\n';
            },
            Existing::replace);
        return true;
    } catch (const InputError &) {
        return false;
    } catch (const std::filesystem::filesystem_error &) {
        return false;
    }
}

} // namespace springdrive::session
