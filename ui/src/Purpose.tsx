/** Asks why two ports are connected that do not fit; the connection keeps the reason. */

import { useState } from "react";
import type { Fit, PortAddress } from "./protocol/Ui.ts";
import { Question } from "./kit/Dialog.tsx";
import { store } from "./store.ts";
import { t } from "./texts.ts";

export interface Misfit {
  here: PortAddress;
  fit: Fit;
}

export function Purpose({ misfit: { here, fit }, close }: { misfit: Misfit; close: () => void }) {
  const [reason, say] = useState("");
  const connect = () =>
    void store.order({
      case: "wire",
      value: { source: here, target: fit.port, name: "", properties: [{ name: `rtgen.allow.${fit.allow}`, text: reason.trim() }] },
    });
  return (
    <Question text={t("{refused}. Connect them on purpose?", { refused: fit.refused })} name={t("Connect")} yes={connect} close={close}>
      <label>
        {t("Reason")}
        <input required autoFocus pattern=".*\S.*" value={reason} onChange={(e) => say(e.target.value)} />
      </label>
    </Question>
  );
}
