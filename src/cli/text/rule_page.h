/* rule_page.h: a rule in HTML: what it means, with a picture of wrong and one of right. */
#ifndef NORMA_CLI_RULE_PAGE_H
#define NORMA_CLI_RULE_PAGE_H
#include <norma/check.h>
#include <stdio.h>

void cli_write_rule_style(FILE *out); /* CSS, and once on a page the marks, which pictures use */
void cli_write_rule_marks(FILE *out);
/* An article whose id is the rule's; level: of its heading. */
void cli_write_rule_html(FILE *out, const norma_rule *rule, int level);
#endif
