// Runs the checks of the core on the board's processor.
#include "device/usb/board/arm/semihosting.h"
#include "tests/device/usb/core_checks.h"

int main() {
    using namespace springdrive;
    int failures = 0;
    for (const testing::CoreCheck &check : testing::kCoreChecks) {
        const bool holds = check.holds();
        failures += holds ? 0 : 1;
        semihosting::write(holds ? "  holds  " : "  FAILS  ");
        semihosting::write(check.name);
        semihosting::write("\n");
    }
    semihosting::write("  a Board has ");
    semihosting::write(sizeof(board::Board));
    semihosting::write(" bytes\n");
    return failures == 0 ? 0 : 1;
}
