/* startup_checks.h: before anything is opened: closed standard streams, mapped files that become
 * shorter. */
#ifndef NORMA_CLI_STARTUP_CHECKS_H
#define NORMA_CLI_STARTUP_CHECKS_H

void cli_startup_checks(void);
#endif
