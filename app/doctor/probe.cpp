#include "app/doctor/probe.h"

#include "app/doctor/check.h"
#include "app/doctor/child_answer.h"
#include "base/input_error.h"
#include "base/real_time_thread.h"
#include "device/usb/driver/board_survey.h"
#include "device/usb/driver/libusb_port.h"
#include "engine/record/record_header.h"
#include "engine/servo/real_time.h"

#include <nlohmann/json.hpp>

#include <functional>
#include <optional>
#include <thread>

// Answers pass between processes as JSON. Both ends are this program, but an answer may be that of
// a process that went wrong: what does not parse is none.
namespace springdrive::usb {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SurveyedBoard, bus, address, sysfs_name, serial, speed, firmware,
                                   obstacle, problem)
} // namespace springdrive::usb

namespace springdrive::app::doctor {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RightsProbe, has_answered, priority, priority_refused,
                                   memory_locked, idle_is_short)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PictureProbe, has_answered, display_problem, window_problem,
                                   version, renderer)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DiskProbe, has_answered, refused, written_bytes_per_s,
                                   longest_sync_s, free_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(UsbProbe, has_answered, problem, boards)

namespace {

/// The priority last, and on a thread that ends at once: with it, this process could hold up a
/// servo that is running.
RightsProbe try_rights(int priority) {
    RightsProbe probe;
    const servo::ShortIdle short_idle;
    probe.idle_is_short = short_idle.warning().empty();
    probe.priority = priority;
    probe.memory_locked = servo::request_locked_memory();
    std::thread([&] { probe.priority_refused = request_priority(priority); }).join();
    return probe;
}

UsbProbe try_usb() {
    UsbProbe probe;
    try {
        probe.boards = usb::survey_boards();
    } catch (const InputError &error) {
        probe.problem = error.what();
    }
    return probe;
}

/// In a process of its own, from now on.
template <typename Probe> class Asked {
public:
    explicit Asked(const std::function<Probe()> &work)
        : child_([&work] {
              Probe probe = work();
              probe.has_answered = true;
              return nlohmann::json(probe).dump(-1, ' ', true,
                                                nlohmann::json::error_handler_t::replace);
          }) {}

    [[nodiscard]] Probe by(ChildAnswer::Clock::time_point deadline) {
        const std::optional<std::string> answer = child_.by(deadline);
        try {
            return answer ? nlohmann::json::parse(*answer).get<Probe>() : Probe();
        } catch (const nlohmann::json::exception &) {
            return {};
        }
    }

private:
    ChildAnswer child_;
};

} // namespace

double record_bytes_per_s(double servo_hz) {
    return record::record_header(servo_hz).row_bytes * servo_hz;
}

Probes try_all(const Purpose &purpose) {
    const auto deadline = ChildAnswer::Clock::now() + kProbeTime;
    const int priority = purpose.uses_usb ? usb::kPortThreadPriority : servo::kServoPriority;
    const auto second_bytes = static_cast<std::size_t>(record_bytes_per_s(purpose.servo_hz));
    Asked<UsbProbe> usb(try_usb);
    Asked<PictureProbe> picture(try_picture);
    Asked<DiskProbe> disk([&] { return try_disk(purpose.folder, second_bytes); });
    // Last: with its priority it could hold up the others on a computer with one processor.
    Asked<RightsProbe> rights([&] { return try_rights(priority); });
    Probes probes;
    probes.rights = rights.by(deadline);
    probes.disk = disk.by(deadline);
    probes.picture = picture.by(deadline);
    probes.usb = usb.by(deadline);
    return probes;
}

} // namespace springdrive::app::doctor
