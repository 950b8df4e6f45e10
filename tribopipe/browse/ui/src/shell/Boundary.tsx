import { Component, type ReactNode } from "react";

interface State {
  error: Error | null;
}

/** Keeps a page that fails from taking the others along. */
export class Boundary extends Component<{ children: ReactNode }, State> {
  override state: State = { error: null };

  static getDerivedStateFromError(error: unknown): State {
    return { error: error instanceof Error ? error : new Error(String(error)) };
  }

  override render(): ReactNode {
    if (this.state.error === null) return this.props.children;
    return (
      <div className="page">
        <div className="notice notice-bad" role="alert">
          <strong>This page cannot be shown</strong>
          <p>{this.state.error.message}</p>
          <p>
            <button type="button" className="button" onClick={() => location.reload()}>
              Reload
            </button>
          </p>
        </div>
      </div>
    );
  }
}
