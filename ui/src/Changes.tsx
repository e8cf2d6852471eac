/** What a command changes in files, line by line. */

import type { FileChange } from "./protocol/Ui.ts";
import { t } from "./texts.ts";

/** Changes of more files are folded. */
const MOST_OPEN = 20;

export function Changes({ changes }: { changes: readonly FileChange[] }) {
  return changes.map((each) => (
    <details key={each.file} open={changes.length <= MOST_OPEN}>
      <summary>
        {each.file}
        {each.moved_to && ` ${t("becomes {file}", { file: each.moved_to })}`}
      </summary>
      <pre>
        {each.lines.split("\n").map((line, i) => (
          <span key={i} className={line.startsWith("+") ? "added" : line.startsWith("-") ? "gone" : "near"}>
            {`${line}\n`}
          </span>
        ))}
      </pre>
    </details>
  ));
}
