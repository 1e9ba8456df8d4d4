#!/bin/bash
# norma mcp with the clients of the protocol's own SDK and with its inspector (tests/mcp/package-lock.json, which scripts/install-deps.sh all installs): tests/mcp. A recorded dialogue is in
# tests/cli/golden/mcp.case.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
modules=${NORMA_NPM_MCP:-$root/build/npm-mcp/node_modules}
if [ ! -d "$modules/@modelcontextprotocol" ]; then
    skip "norma mcp (its SDK is not installed: scripts/install-deps.sh all)"
else
    mkdir "$scratch/mcp"
    relay mcp node "$root/tests/mcp/mcp.mjs" "${NORMA_BIN:-$tree/bin/norma}" "$scratch/mcp" "$modules" "$root/tests/cli/golden/files"
fi
inspector=$modules/@modelcontextprotocol/inspector/cli/build/cli.js
if [ ! -f "$inspector" ]; then
    skip "norma mcp with the protocol's inspector (it is not installed: scripts/install-deps.sh all)"
else
    mkdir "$scratch/inspector"
    relay inspector node "$root/tests/mcp/inspector.mjs" "${NORMA_BIN:-$tree/bin/norma}" "$scratch/inspector" "$inspector" "$root/tests/cli/golden/files"
fi
finish
