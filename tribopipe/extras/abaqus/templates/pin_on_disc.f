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
C     V      sliding speed [mm/s]
C     EC     contact modulus E_c [MPa]
C     HEL    length of an element of the contact surface [mm]: set it to
C            that of your mesh; in 3-D to 0.7 of it, where a
C            checkerboard may alternate both ways
      PARAMETER (WK = $wear_coefficient)
      PARAMETER (V = $speed)
      PARAMETER (EC = $modulus)
      PARAMETER (HEL = $element)
${law_parameters}C
C     DTMAX  longest stable increment [s]
      PARAMETER (DTMAX = 1.2D0*HEL/(WK*EC*V$largest_factor))
C
      CALL TPPRES(NODE,P,JMATYP,JGVBLOCK)
      RATE = WK*P*V
${law}C
C     The last local direction is the outward normal of the surface.
      ULOCAL(NDIM) = ULOCAL(NDIM) - RATE
C
