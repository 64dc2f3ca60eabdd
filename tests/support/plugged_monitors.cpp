#include "tests/support/plugged_monitors.h"

#include <fmt/core.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace springdrive::testing {

namespace {

std::vector<std::string> server_in(const std::filesystem::path &folder) {
    const std::filesystem::path configuration = folder / "xorg.conf";
    std::ofstream(configuration) << R"(
Section "ServerFlags"
  Option "AutoAddDevices" "false"
EndSection
Section "Device"
  Identifier "no card"
  Driver "dummy"
  VideoRam 256000
EndSection
Section "Screen"
  Identifier "all monitors"
  Device "no card"
  DefaultDepth 24
  SubSection "Display"
    Depth 24
    Modes "1024x768"
    Virtual 8192 4096
  EndSubSection
EndSection
)";
    return {"Xorg",        "-config",           configuration.string(),
            "-logfile",    folder / "xorg.log", "-noreset",
            "-novtswitch", "-sharevts"};
}

} // namespace

PluggedMonitors::PluggedMonitors(const std::filesystem::path &folder)
    : display_(server_in(folder)) {}

void PluggedMonitors::plug(int monitor, int width, int height) {
    // Blanking does not matter where nothing is scanned out: 60 frames a second.
    const std::string mode = fmt::format("test{}x{}", width, height);
    const int line = width + 160;
    const int lines = height + 30;
    static_cast<void>(std::system(
        fmt::format("export DISPLAY={}; xrandr --newmode {} {:.2f} {} {} {} {} {} {} {} {} "
                    "2>/dev/null; xrandr --addmode DUMMY{} {} 2>/dev/null",
                    display_.name(), mode, 60e-6 * line * lines, width, width + 48, width + 80,
                    line, height, height + 3, height + 8, lines, monitor, mode)
            .c_str())); // either may be there already
    set(fmt::format("--output DUMMY{} --mode {} --right-of DUMMY0", monitor, mode));
}

void PluggedMonitors::pull(int monitor) { set(fmt::format("--output DUMMY{} --off", monitor)); }

/// The dummy driver notices by a query only that a monitor is there: a real one, by itself.
void PluggedMonitors::set(const std::string &arguments) const {
    if (std::system(fmt::format("DISPLAY={0} xrandr {1} && DISPLAY={0} xrandr --query >/dev/null",
                                display_.name(), arguments)
                        .c_str()) != 0) {
        throw std::runtime_error("xrandr refuses " + arguments);
    }
}

} // namespace springdrive::testing
