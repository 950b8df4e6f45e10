import "./run.css";

import type { Run } from "../api";
import { Failure } from "../components/Failure";
import { useAnswer } from "../shell/useAnswer";
import { useTitle } from "../shell/useTitle";
import { Contents, type Section } from "./Contents";
import { Findings } from "./Findings";
import { Glance } from "./Glance";
import { Measured } from "./Measured";
import { NotThere } from "./NotThere";
import { apiOf, stageId } from "./places";
import { Provenance } from "./Provenance";
import { Recorded, recorded } from "./Recorded";
import { Remarks } from "./Remarks";
import { RunHead } from "./RunHead";
import { Skeleton } from "./Skeleton";
import { Sources } from "./Sources";
import { StageSection } from "./StageSection";
import { useAnchor } from "./useAnchor";

/** One run: what came out, what was measured, every stage, where it all comes from. */
export default function RunPage({ id }: { id: string }) {
  useTitle(id);
  const { answer: run, error } = useAnswer<Run>(apiOf(id));
  useAnchor(run !== null);
  if (run === null) {
    if (error === null) return <Skeleton what="the run" />;
    return <NotThere title={id} error={error} back={{ href: "/", label: "All runs" }} />;
  }
  return (
    <div className="page">
      {error && <Failure error={error} />}
      <RunHead run={run} />
      <div className="with-contents">
        <Contents sections={sections(run)} />
        <Parts run={run} />
      </div>
    </div>
  );
}

function Parts({ run }: { run: Run }) {
  const offers = recorded(run);
  return (
    <div className="parts">
      <Glance run={run} />
      <Findings run={run} />
      {run.remarks.length > 0 && <Remarks remarks={run.remarks} />}
      <Measured run={run} />
      {offers.length > 0 && <Recorded run={run} offers={offers} />}
      {run.stages.map((stage) => (
        <StageSection key={stage.name} run={run} stage={stage} />
      ))}
      <Provenance run={run} />
      <Sources run={run} />
    </div>
  );
}

function sections(run: Run): Section[] {
  return [
    { id: "result", title: "Result" },
    { id: "findings", title: "Findings" },
    ...(run.remarks.length > 0 ? [{ id: "remarks", title: "Remarks" }] : []),
    { id: "measured", title: "Test and measurements" },
    ...(recorded(run).length > 0 ? [{ id: "recorded", title: "Recorded signals" }] : []),
    ...run.stages.map(({ name, title }) => ({ id: stageId(name), title })),
    { id: "provenance", title: "Provenance" },
    { id: "sources", title: "Source files" },
  ];
}
