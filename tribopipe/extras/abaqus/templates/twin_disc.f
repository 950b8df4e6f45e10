      SUBROUTINE UMESHMOTION(UREF,ULOCAL,NODE,NNDOF,
     *    LNODETYPE,ALOCAL,NDIM,TIME,DTIME,PNEWDT,
     *    KSTEP,KINC,KMESHSWEEP,JMATYP,JGVBLOCK,LSMOOTH)
C
      INCLUDE 'ABA_PARAM.INC'
C
      DIMENSION ULOCAL(NDIM),ALOCAL(NDIM,*),TIME(2)
      DIMENSION JMATYP(*),JGVBLOCK(*)
C
C     WK     k_D [mm^3/(N mm)]
C     TURNS  slip rotations per time |V1-V2|/(2 pi r) [1/s]
C     EC     contact modulus E_c [MPa]
C     CLEN   length of the contact along the direction of rolling [mm]
C     HEL    width of an element of the contact surface, across the
C            direction of rolling [mm]: set it to that of your mesh
      PARAMETER (WK = $wear_coefficient)
      PARAMETER (TURNS = $turns)
      PARAMETER (EC = $modulus)
      PARAMETER (CLEN = $contact_length)
      PARAMETER (HEL = $element)
${law_parameters}C
C     DTMAX  longest stable increment [s]
      PARAMETER (DTMAX = 1.2D0*HEL/(WK*EC*CLEN*TURNS$largest_factor))
C
C     SUMPDL integral of p along the streamline [N/mm]
      CALL TPLINE(NODE,SUMPDL,DTIME,KSTEP,KINC,JMATYP,JGVBLOCK)
      RATE = WK*SUMPDL*TURNS
${law}C
C     The last local direction is the outward normal of the surface.
      ULOCAL(NDIM) = ULOCAL(NDIM) - RATE
C
