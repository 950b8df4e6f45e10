"""A wear law for ABAQUS: the user subroutine UMESHMOTION (paper, Section 3.3) written from an identified k_D."""
